#include "compiler/evaluate/distributions.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/names/names.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "dsl/text/utf8.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using Eigen::Vector3d;
using schema::DistributionKind;
using schema::Number;
using schema::Value;

/// The weight of a choice of any( ): 1 if none is given.
std::optional<double> WeightOf(const dsl::Argument& argument, const scenario::Scope& scope,
                               Evaluator& evaluator) {
  if (!argument.weight) return 1;
  const auto number = evaluator.EvaluateNumber(*argument.weight, scope, "weights");
  if (!number) return std::nullopt;
  if (!(number->AsReal() > 0))
    return evaluator.Error(scenario::kOutOfDomain, argument.weight->span,
                           "a weight must be greater than 0",
                           "remove choices that should never be drawn");
  return number->AsReal();
}

/// Adds a choice of any( ); false after a diagnostic.
bool AddChoice(const dsl::Argument& argument, const scenario::Scope& scope, Evaluator& evaluator,
               schema::Distribution& drawn) {
  if (argument.name) {
    evaluator.Error(scenario::kBadArguments, argument.name->span,
                    fmt::format("any() has no argument '{}'", argument.name->text),
                    "a weight follows its choice: any(sphere 3, cone 1)");
    return false;
  }
  const auto choice = evaluator.Evaluate(*argument.value, scope);
  const auto weight = WeightOf(argument, scope, evaluator);
  if (choice && AsDistribution(*choice)) {
    evaluator.Error(scenario::kBadArguments, argument.value->span,
                    "a distribution cannot be a choice of any( )");
    return false;
  }
  if (choice && AsFormula(*choice)) {
    RefuseFormula(*AsFormula(*choice), evaluator.diagnostics());
    return false;
  }
  if (!choice || !weight) return false;
  drawn.arguments.push_back(*choice);
  drawn.weights.push_back(*weight);
  return true;
}

/// A distribution of two numbers or two vectors while it is evaluated.
class PairDistribution {
 public:
  PairDistribution(const Expr& call, DistributionKind kind, const scenario::Scope& scope,
                   Evaluator& evaluator)
      : call_(call),
        kind_(kind),
        is_normal_(kind == DistributionKind::kNormal),
        usage_(is_normal_ ? "normal(mean, deviation), or normal(mean, variance: v)"
                          : "uniform(least, most)"),
        scope_(scope),
        evaluator_(evaluator) {}

  std::optional<Value> Evaluate() {
    for (const dsl::Argument& argument : call_.arguments)
      if (!CheckForm(argument) || !Add(argument)) return std::nullopt;
    if (!MatchKinds() || !CheckDomain()) return std::nullopt;
    if (is_variance_) arguments_[1] = DeviationOf(arguments_[1]);
    return schema::Distribution{kind_, std::move(arguments_), {}};
  }

 private:
  bool Fail(const dsl::DiagnosticKind& kind, const text::Span& span, std::string message,
            std::string help = {}) {
    evaluator_.Error(kind, span, std::move(message), std::move(help));
    return false;
  }

  bool CheckForm(const dsl::Argument& argument) {
    if (argument.weight)
      return Fail(scenario::kBadArguments, argument.weight->span,
                  fmt::format("{}() does not take weights", call_.text), usage_);
    if (!argument.name) return true;
    is_variance_ = argument.name->text == "variance";
    const bool is_second = arguments_.size() == 1;
    if (is_normal_ && is_second && (is_variance_ || argument.name->text == "sd")) return true;
    return Fail(scenario::kBadArguments, argument.name->span,
                fmt::format("{}() has no argument '{}'{}", call_.text, argument.name->text,
                            is_normal_ && !is_second ? " there" : ""),
                usage_);
  }

  bool Add(const dsl::Argument& argument) {
    const auto value = evaluator_.Evaluate(*argument.value, scope_);
    if (!value) return false;
    if (AsFormula(*value)) {
      RefuseFormula(*AsFormula(*value), evaluator_.diagnostics());
      return false;
    }
    if (!AsNumber(*value) && !AsVector(*value))
      return Fail(scenario::kWrongKind, argument.value->span,
                  fmt::format("{}() takes numbers or vectors, but this is {}", call_.text,
                              names::KindName(*value)),
                  usage_);
    arguments_.push_back(*value);
    return true;
  }

  /// Makes both numbers or both vectors: 0 beside a vector becomes a vector.
  bool MatchKinds() {
    if (arguments_.size() != 2)
      return Fail(scenario::kBadArguments, call_.span,
                  fmt::format("{}() takes two values, but there {} {}", call_.text,
                              arguments_.size() == 1 ? "is" : "are", arguments_.size()),
                  usage_);
    const auto widen = [](Value& value, const Value& other) {
      if (AsNumber(value) && AsVector(other) && AsNumber(value)->AsReal() == 0)
        value = Value(Vector3d(Vector3d::Zero()));
    };
    widen(arguments_[0], arguments_[1]);
    widen(arguments_[1], arguments_[0]);
    if ((AsVector(arguments_[0]) != nullptr) == (AsVector(arguments_[1]) != nullptr)) return true;
    return Fail(scenario::kBadArguments, call_.span, "one value is a number, the other a vector",
                "write both as numbers or both as vectors");
  }

  bool CheckDomain() {
    // Numbers become vectors of three equal components, so that one check serves both.
    const auto triple = [](const Value& value) {
      return AsVector(value) ? *AsVector(value)
                             : Vector3d(Vector3d::Constant(AsNumber(value)->AsReal()));
    };
    const Vector3d a = triple(arguments_[0]), b = triple(arguments_[1]);
    if (is_normal_ && (b.array() < 0).any())
      return Fail(
          scenario::kOutOfDomain, call_.arguments[1].value->span,
          fmt::format("a {} is 0 or more", is_variance_ ? "variance" : "standard deviation"));
    if (!is_normal_ && (a.array() > b.array()).any())
      return Fail(scenario::kOutOfDomain, call_.span,
                  fmt::format("the lower bound, {}, is greater than the upper, {}",
                              ToText(arguments_[0]), ToText(arguments_[1])),
                  "swap them");
    if (kind_ == DistributionKind::kLogUniform && (a.array() <= 0).any())
      return Fail(scenario::kOutOfDomain, call_.arguments[0].value->span,
                  "log_uniform() takes values greater than 0");
    return true;
  }

  static Value DeviationOf(const Value& variance) {
    if (AsVector(variance)) return Value(Vector3d(AsVector(variance)->array().sqrt()));
    return std::sqrt(AsNumber(variance)->AsReal());
  }

  const Expr& call_;
  const DistributionKind kind_;
  const bool is_normal_;
  const char* const usage_;
  const scenario::Scope& scope_;
  Evaluator& evaluator_;
  std::vector<Value> arguments_;
  bool is_variance_ = false;  ///< whether the second argument is a variance
};

/// Evaluates `in 2 .. 8`; nullopt after a diagnostic.
std::optional<schema::Limits> LimitsOf(const Expr& call, const scenario::Scope& scope,
                                       Evaluator& evaluator) {
  const auto least = evaluator.EvaluateNumber(*call.items[0], scope, "limits");
  const auto most = evaluator.EvaluateNumber(*call.items[1], scope, "limits");
  if (!least || !most) return std::nullopt;
  if (Compare(*least, *most) < 0) return schema::Limits{least->AsReal(), most->AsReal()};
  return evaluator.Error(scenario::kOutOfDomain, call.items[0]->span,
                         fmt::format("the lower limit, {}, is not less than the upper, {}",
                                     least->Text(), most->Text()));
}

}  // namespace

std::optional<Value> EvaluateAny(const Expr& call, const scenario::Scope& scope,
                                 Evaluator& evaluator) {
  if (call.arguments.empty())
    return evaluator.Error(scenario::kBadArguments, call.span, "any() has no choices");
  schema::Distribution drawn;
  drawn.kind = DistributionKind::kAny;
  bool good = true;
  for (const dsl::Argument& argument : call.arguments)
    good = AddChoice(argument, scope, evaluator, drawn) && good;
  if (!good) return std::nullopt;
  if (!call.items.empty())
    return evaluator.Error(scenario::kBadArguments, call.items[0]->span,
                           "any() draws from a list and cannot have limits",
                           "remove the values outside of them");
  return drawn;
}

std::optional<Value> EvaluateDistribution(const Expr& call, DistributionKind kind,
                                          const scenario::Scope& scope, Evaluator& evaluator) {
  using enum DistributionKind;
  std::optional<Value> drawn;
  if (kind == kAny) return EvaluateAny(call, scope, evaluator);
  if (kind == kEmpirical) {
    drawn = EvaluateEmpirical(call, evaluator);
  } else if (kind == kUniform || kind == kNormal || kind == kLogUniform) {
    drawn = PairDistribution(call, kind, scope, evaluator).Evaluate();
  } else {
    drawn = EvaluatePositive(call, kind, scope, evaluator);
  }
  if (!drawn || call.items.empty()) return drawn;
  const auto limits = LimitsOf(call, scope, evaluator);
  if (!limits) return std::nullopt;
  schema::Distribution limited = *AsDistribution(*drawn);
  limited.limits = limits;
  return limited;
}

namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// An argument and its range.
struct PositiveArgument {
  std::string_view name;
  double least, most;
};

// Draws of lognormal must fit into a double; shapes below 0.01 draw almost only 0.
constexpr PositiveArgument kLognormalArguments[] = {{"mu", -500, 500}, {"sigma", 0, 20}};
constexpr PositiveArgument kExponentialArguments[] = {{"mean", 0, kUnlimited}};
constexpr PositiveArgument kShapeArguments[] = {{"shape", 0.01, 1e6}, {"scale", 0, kUnlimited}};

std::span<const PositiveArgument> ArgumentsFor(DistributionKind kind) {
  if (kind == DistributionKind::kLognormal) return kLognormalArguments;
  if (kind == DistributionKind::kExponential) return kExponentialArguments;
  return kShapeArguments;
}

class PositiveEvaluation {
 public:
  PositiveEvaluation(const dsl::Expr& call, DistributionKind kind, const scenario::Scope& scope,
                     Evaluator& evaluator)
      : call_(call),
        kind_(kind),
        scope_(scope),
        evaluator_(evaluator),
        row_(ArgumentsFor(kind)),
        values_(row_.size()) {}

  std::optional<Value> Evaluate() {
    for (std::size_t i = 0; i < call_.arguments.size(); ++i)
      if (!Add(i)) return std::nullopt;
    if (std::ranges::any_of(values_, [](const auto& value) { return !value; }))
      return Fail(call_.span,
                  fmt::format("{}() takes {} number{}, but there {} {}", call_.text, row_.size(),
                              row_.size() == 1 ? "" : "s",
                              call_.arguments.size() == 1 ? "is" : "are", call_.arguments.size()));
    schema::Distribution drawn{kind_, {}, {}};
    for (const auto& value : values_) drawn.arguments.emplace_back(*value);
    return drawn;
  }

 private:
  std::nullopt_t Fail(const text::Span& span, std::string message) {
    return evaluator_.Error(scenario::kBadArguments, span, std::move(message),
                            std::string(schema::InfoOf(kind_).usage));
  }

  bool Add(std::size_t i) {
    const dsl::Argument& argument = call_.arguments[i];
    if (argument.weight) {
      Fail(argument.weight->span, fmt::format("{}() does not take weights", call_.text));
      return false;
    }
    const bool is_median =
        argument.name && argument.name->text == "median" && kind_ == DistributionKind::kLognormal;
    std::size_t place = is_median ? 0 : i;
    if (argument.name && !is_median)
      place = static_cast<std::size_t>(
          std::ranges::find(row_, argument.name->text, &PositiveArgument::name) - row_.begin());
    if (place >= row_.size()) {
      Fail(argument.name ? argument.name->span : argument.value->span,
           argument.name ? fmt::format("{}() has no argument '{}'", call_.text, argument.name->text)
                         : fmt::format("{}() takes at most {} number{}", call_.text, row_.size(),
                                       row_.size() == 1 ? "" : "s"));
      return false;
    }
    if (values_[place]) {
      Fail(argument.value->span, fmt::format("'{}' is given twice", row_[place].name));
      return false;
    }
    return Evaluate(argument, place, is_median);
  }

  bool Evaluate(const dsl::Argument& argument, std::size_t place, bool is_median) {
    const auto number = evaluator_.EvaluateNumber(*argument.value, scope_, "its arguments");
    if (!number) return false;
    const PositiveArgument& row = row_[place];
    const double value = number->AsReal();
    const bool is_open = row.least == 0 && row.name != "sigma";
    const bool fits = is_median
                          ? value > 0
                          : (is_open ? value > row.least : value >= row.least) && value <= row.most;
    if (fits) {
      values_[place] = is_median ? std::log(value) : value;
      return true;
    }
    std::string wanted = "more than 0";
    if (!is_median && row.most != kUnlimited)
      wanted = fmt::format("from {} to {}", row.least, row.most);
    evaluator_.Error(
        scenario::kOutOfDomain, argument.value->span,
        fmt::format("the {} of {}() must be {}, not {}", is_median ? "median" : row.name,
                    call_.text, wanted, number->Text()));
    return false;
  }

  const dsl::Expr& call_;
  const DistributionKind kind_;
  const scenario::Scope& scope_;
  Evaluator& evaluator_;
  const std::span<const PositiveArgument> row_;
  std::vector<std::optional<double>> values_;
};

}  // namespace

std::optional<Value> EvaluatePositive(const dsl::Expr& call, DistributionKind kind,
                                      const scenario::Scope& scope, Evaluator& evaluator) {
  return PositiveEvaluation(call, kind, scope, evaluator).Evaluate();
}

namespace {

std::string_view TrimmedField(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r";
  const std::size_t first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) + 1 - first);
}

std::optional<double> TableNumber(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// A heading is a word: `size_mm`, `"size"`.
bool IsHeading(std::string_view field) {
  return !field.empty() && (field[0] == '"' || text::IsLetter(field[0]));
}

/// Reads a table line by line; `fault` describes the error in the line added last.
class TableReader {
 public:
  bool Add(std::string_view line) {
    line = TrimmedField(line.substr(0, line.find('#')));
    if (line.empty()) return true;
    const std::vector<std::string_view> fields = Split(line);
    if (std::exchange(is_first_, false) && IsHeading(fields[0])) return true;
    if (fields.size() > 2)
      return Refuse(
          fmt::format("{} columns; a table has a column of values, and may have one of weights",
                      fields.size()));
    if (columns_ != 0 && fields.size() != columns_)
      return Refuse(fmt::format("{} column{}, but {} in the lines before", fields.size(),
                                fields.size() == 1 ? "" : "s", columns_));
    columns_ = fields.size();
    if (table_.arguments.size() == kMaxTableValues)
      return Refuse(fmt::format("more than {} values", kMaxTableValues));
    return AddValue(fields[0]) && (fields.size() == 1 || AddWeight(fields[1]));
  }

  schema::Distribution& table() { return table_; }
  const std::string& fault() const { return fault_; }

 private:
  static std::vector<std::string_view> Split(std::string_view line) {
    std::vector<std::string_view> fields;
    for (std::size_t comma = 0; comma != std::string_view::npos;) {
      comma = line.find(',');
      fields.push_back(TrimmedField(line.substr(0, comma)));
      if (comma != std::string_view::npos) line.remove_prefix(comma + 1);
    }
    return fields;
  }

  bool AddValue(std::string_view field) {
    const auto value = TableNumber(field);
    if (!value) return Refuse(fmt::format("'{}' is not a finite number", text::Printable(field)));
    table_.arguments.emplace_back(*value);
    return true;
  }

  bool AddWeight(std::string_view field) {
    const auto weight = TableNumber(field);
    if (!weight || !(*weight > 0))
      return Refuse(fmt::format("'{}' is not a weight greater than 0", text::Printable(field)));
    table_.weights.push_back(*weight);
    return true;
  }

  bool Refuse(std::string fault) {
    fault_ = std::move(fault);
    return false;
  }

  schema::Distribution table_{schema::DistributionKind::kEmpirical, {}, {}};
  std::size_t columns_ = 0;
  bool is_first_ = true;
  std::string fault_;
};

}  // namespace

std::optional<schema::Value> EvaluateEmpirical(const dsl::Expr& call, Evaluator& evaluator) {
  const bool is_text = call.arguments.size() == 1 && !call.arguments[0].name &&
                       !call.arguments[0].weight &&
                       call.arguments[0].value->kind == dsl::ExprKind::kText;
  if (!is_text)
    return evaluator.Error(scenario::kBadArguments, call.span,
                           "empirical() takes the name of a file in quotes",
                           "write empirical(\"sizes.csv\")");
  const dsl::Expr& name = *call.arguments[0].value;
  const auto folder = std::filesystem::path(name.span.source->name()).parent_path();
  const std::string path = (folder / name.text).lexically_normal().string();
  std::string why;
  const auto text = evaluator.scenario().TextOf(path, why);
  if (!text)
    return evaluator.Error(scenario::kNoSuchFile, name.span,
                           fmt::format("cannot read '{}': {}", path, why),
                           "the path is relative to the folder of the .cdb file that names it");
  TableReader reader;
  std::string_view rest = *text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  for (std::size_t line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    if (!reader.Add(rest.substr(0, end)))
      return evaluator.Error(scenario::kBadTable, name.span,
                             fmt::format("{}:{}: {}", path, line, reader.fault()),
                             "a line contains a value, or a value, a comma and its weight");
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  schema::Distribution& table = reader.table();
  if (table.arguments.empty())
    return evaluator.Error(scenario::kBadTable, name.span,
                           fmt::format("'{}' contains no value", path));
  table.file = path;
  return std::move(table);
}

}  // namespace cdb::evaluate
