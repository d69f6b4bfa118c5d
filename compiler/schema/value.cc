#include "compiler/schema/value.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "compiler/schema/formula.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"

namespace cdb::schema {
namespace {

constexpr DistributionInfo kDistributions[] = {
    {"uniform", DistributionKind::kUniform, 2, "uniform(least, most)"},
    {"normal", DistributionKind::kNormal, 2,
     "normal(mean, deviation), or normal(mean, variance: v)"},
    {"log_uniform", DistributionKind::kLogUniform, 2, "log_uniform(least, most)"},
    {"any", DistributionKind::kAny, 0, "any(a, b 3)"},
    {"lognormal", DistributionKind::kLognormal, 2,
     "lognormal(mu, sigma) of the logarithm, or lognormal(median: m, sigma: s)"},
    {"exponential", DistributionKind::kExponential, 1, "exponential(mean)"},
    {"gamma", DistributionKind::kGamma, 2, "gamma(shape, scale)"},
    {"weibull", DistributionKind::kWeibull, 2, "weibull(shape, scale)"},
    {"empirical", DistributionKind::kEmpirical, 0, "empirical(\"sizes.csv\")"}};

std::string QuotedText(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n' || c == '\t') {
      quoted += c == '\n' ? "\\n" : "\\t";
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string PointsText(const Call& call) {
  std::string text;
  for (const Value& point : call.arguments)
    text += fmt::format("{}{}", text.empty() ? "" : ", ", ToText(point));
  return fmt::format("{}({})", call.name, text);
}

/// Only arguments that differ from their defaults; required arguments without their names, unless
/// an optional one comes before them.
std::string CallText(const Call& call) {
  const ParametrisedWord* info = FindParametrisedWord(call.name);
  CDB_CHECK(info != nullptr);
  if (ListsPoints(call)) return PointsText(call);
  std::string text;
  for (const Value& part : PartsOf(call))
    text += fmt::format("{}{}", text.empty() ? "" : ", ", ToText(part));
  bool is_by_name = false;
  for (std::size_t i = 0; i < info->arguments.size(); ++i) {
    const Parameter& argument = info->arguments[i];
    const std::string value = ToText(call.arguments[i]);
    is_by_name = is_by_name || !argument.DefaultText().empty();
    if (value == argument.DefaultText()) continue;
    if (!text.empty()) text += ", ";
    if (is_by_name) text += fmt::format("{}: ", argument.name);
    text += value;
  }
  return text.empty() ? call.name : fmt::format("{}({})", call.name, text);
}

/// Users do not write hashes, nor numbers of nodes, and an axis does not need them to distinguish
/// its values.
Call WithoutHash(Call call) {
  const ParametrisedWord& info = *FindParametrisedWord(call.name);
  if (NamesFile(info)) call.arguments[1] = DefaultOf(info.arguments[1]);
  if (call.name == kSoftCall) call.arguments.back() = DefaultOf(info.arguments.back());
  for (Value& argument : call.arguments)
    if (const Call* inner = AsCall(argument)) argument = WithoutHash(*inner);
  return call;
}

struct TextOf {
  bool is_label;

  std::string operator()(bool on) const { return on ? "on" : "off"; }
  std::string operator()(const Number& number) const { return number.Text(); }
  std::string operator()(const Word& word) const { return word.text; }
  std::string operator()(const Eigen::Vector3d& v) const {
    return fmt::format("({}, {}, {})", FormatReal(v.x()), FormatReal(v.y()), FormatReal(v.z()));
  }
  std::string operator()(const Ratio& r) const {
    return fmt::format("{} : {} : {}", FormatReal(r.parts.x()), FormatReal(r.parts.y()),
                       FormatReal(r.parts.z()));
  }
  std::string operator()(const WordList& words) const {
    return fmt::format("{}", fmt::join(words, ", "));
  }
  std::string operator()(const Text& text) const {
    return is_label ? text.text : QuotedText(text.text);
  }
  std::string operator()(const Call& call) const {
    return CallText(is_label ? WithoutHash(call) : call);
  }
  std::string operator()(const Distribution& d) const {
    std::string text = std::string(DistributionName(d.kind)) + "(";
    // A label needs only the name of a table; a run needs its values.
    if (d.kind == DistributionKind::kEmpirical) text += QuotedText(d.file);
    for (std::size_t i = 0; i < d.arguments.size(); ++i) {
      if (d.kind == DistributionKind::kEmpirical && is_label) break;
      if (i > 0 || d.kind == DistributionKind::kEmpirical) text += ", ";
      text += Of(d.arguments[i]);
      if (!d.weights.empty() && d.weights[i] != 1) text += " " + FormatReal(d.weights[i]);
    }
    text += ")";
    if (d.limits)
      text += fmt::format(" in {} .. {}", FormatReal(d.limits->least), FormatReal(d.limits->most));
    return text;
  }

  std::string operator()(const Formula& formula) const { return FormulaText(formula); }

  std::string Of(const Value& value) const {
    return std::visit(*this, static_cast<const Value::variant&>(value));
  }
};

}  // namespace

const DistributionInfo& InfoOf(DistributionKind kind) {
  const auto* row = std::ranges::find(kDistributions, kind, &DistributionInfo::kind);
  CDB_CHECK(row != std::end(kDistributions));
  return *row;
}

std::string_view DistributionName(DistributionKind kind) { return InfoOf(kind).name; }

std::optional<DistributionKind> FindDistribution(std::string_view name) {
  const auto* row = std::ranges::find(kDistributions, name, &DistributionInfo::name);
  return row == std::end(kDistributions) ? std::nullopt : std::optional(row->kind);
}

std::vector<std::string_view> DistributionNames() {
  std::vector<std::string_view> names;
  for (const DistributionInfo& row : kDistributions) names.push_back(row.name);
  return names;
}

bool Distribution::operator==(const Distribution& other) const {
  return kind == other.kind && arguments == other.arguments && weights == other.weights &&
         limits == other.limits && file == other.file;
}

bool Call::operator==(const Call& other) const {
  return name == other.name && arguments == other.arguments;
}

bool Formula::operator==(const Formula& other) const {
  return op == other.op && setting == other.setting && arguments == other.arguments;
}

bool MayBe(const Value& value, std::string_view word) {
  if (const Word* one = AsWord(value)) return one->text == word;
  const Distribution* drawn = AsDistribution(value);
  return drawn != nullptr && std::ranges::any_of(drawn->arguments, [&](const Value& choice) {
           return MayBe(choice, word);
         });
}

bool IsIdentical(const Value& a, const Value& b) {
  if (!(a == b)) return false;
  const auto have_same_signs = [](const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
    return x.array()
        .binaryExpr(y.array(),
                    [](double p, double q) {
                      return static_cast<double>(std::signbit(p) == std::signbit(q));
                    })
        .all();
  };
  const auto are_identical = [](const std::vector<Value>& x, const std::vector<Value>& y) {
    return std::ranges::equal(x, y, IsIdentical);
  };
  if (const Number* number = AsNumber(a))
    return std::signbit(number->AsReal()) == std::signbit(AsNumber(b)->AsReal());
  if (const Eigen::Vector3d* vector = AsVector(a)) return have_same_signs(*vector, *AsVector(b));
  if (const Ratio* ratio = AsRatio(a)) return have_same_signs(ratio->parts, AsRatio(b)->parts);
  if (const Call* call = AsCall(a)) return are_identical(call->arguments, AsCall(b)->arguments);
  if (const Formula* formula = AsFormula(a))
    return are_identical(formula->arguments, AsFormula(b)->arguments);
  if (const Distribution* drawn = AsDistribution(a)) {
    const Distribution& other = *AsDistribution(b);
    const auto ends = [](const std::optional<Limits>& limits) {
      return limits ? Eigen::Vector3d(limits->least, limits->most, 0) : Eigen::Vector3d(0, 0, 0);
    };
    return are_identical(drawn->arguments, other.arguments) &&
           have_same_signs(ends(drawn->limits), ends(other.limits));
  }
  return true;
}

std::string ToText(const Value& value) { return TextOf{.is_label = false}.Of(value); }

std::string LabelOf(const Value& value) { return TextOf{.is_label = true}.Of(value); }

}  // namespace cdb::schema
