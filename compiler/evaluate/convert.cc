#include "compiler/evaluate/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "compiler/evaluate/evaluate.h"
#include "compiler/names/names.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/cumulative.h"
#include "compiler/schema/formula.h"

namespace cdb::evaluate {
namespace {

using schema::Integer;
using schema::Value;

/// The minimum probability of draws inside the domain: below it, redrawing would hardly end.
constexpr double kLeastChance = 1e-3;

class Converter {
 public:
  Converter(const schema::Parameter& parameter, const text::Span& span,
            const std::vector<text::Span>& choices, std::span<const schema::PluginDetector> plugins,
            dsl::Diagnostics& diagnostics)
      : parameter_(parameter),
        span_(span),
        choices_(choices),
        plugins_(plugins),
        diagnostics_(diagnostics) {}

  std::optional<Value> Constant(const Value& value) const {
    if (const schema::Word* word = AsWord(value)) return FromWord(*word);
    if (const schema::Call* call = AsCall(value))
      return parameter_.TakesCall(call->name) ? std::optional(Value(*call)) : WrongKind(value);
    if (AsFormula(value)) return FromFormula(value);
    using enum schema::ParameterType;
    switch (parameter_.type) {
      case kCount:
        return FromCount(value);
      case kReal:
        if (!AsNumber(value)) return WrongKind(value);
        if (!InDomain(AsNumber(value)->AsReal(), AsNumber(value)->Text())) return std::nullopt;
        return Value(AsNumber(value)->AsReal());
      case kVector:
        return FromVector(value);
      case kRatio: {
        const schema::Ratio* ratio = AsRatio(value);
        if (ratio == nullptr) return WrongKind(value);
        for (const double part : ratio->parts)
          if (!InDomain(part, schema::FormatReal(part))) return std::nullopt;
        return Value(*ratio);
      }
      case kText:
        if (AsText(value)) return Value(*AsText(value));
        break;
      case kSwitch:
      case kWord:
      case kWords:
        break;
    }
    return WrongKind(value);
  }

  std::optional<Value> Drawn(const schema::Distribution& drawn) const {
    if (!parameter_.distribution)
      return Error(scenario::kWrongKind,
                   fmt::format("'{}' has one value in a run and cannot be drawn", parameter_.name),
                   "sweep(…) makes a run for each of several values");
    return drawn.kind == schema::DistributionKind::kAny ? OfChoices(drawn) : OfNumbers(drawn);
  }

 private:
  std::nullopt_t Error(const dsl::DiagnosticKind& kind, std::string message,
                       std::string help = {}) const {
    diagnostics_.Report(kind, span_, std::move(message), std::move(help));
    return std::nullopt;
  }

  std::optional<Value> OfChoices(schema::Distribution drawn) const {
    bool good = true;
    for (std::size_t i = 0; i < drawn.arguments.size(); ++i) {
      Value& choice = drawn.arguments[i];
      const text::Span& at = i < choices_.size() ? choices_[i] : span_;
      if (AsCall(choice) && !parameter_.ChoosesCalls()) {
        ReportChoice(AsCall(choice)->name, at);
        good = false;
        continue;
      }
      const auto converted = Converter(parameter_, at, {}, {}, diagnostics_).Constant(choice);
      good = good && converted;
      if (converted) choice = *converted;
    }
    return good ? std::optional<Value>(std::move(drawn)) : std::nullopt;
  }

  void ReportChoice(const std::string& call, const text::Span& at) const {
    if (parameter_.type == schema::ParameterType::kVector) {
      diagnostics_.Report(
          scenario::kBadArguments, at,
          fmt::format("{}() lasts for the whole run and cannot be a choice of any()", call),
          "sweep(…) makes a run for each of several");
    } else {
      diagnostics_.Report(scenario::kBadArguments, at,
                          fmt::format("{}() cannot be a choice of any()", call),
                          fmt::format("write any() inside it: {}(any(…))", call));
    }
  }

  std::optional<Value> OfNumbers(schema::Distribution drawn) const {
    const bool are_vectors = AsVector(drawn.arguments[0]) != nullptr;
    if (parameter_.type != schema::ParameterType::kReal &&
        parameter_.type != schema::ParameterType::kVector)
      return Error(scenario::kWrongKind,
                   fmt::format("'{}' takes {}, but {}() draws numbers", parameter_.name,
                               parameter_.Takes(plugins_), schema::DistributionName(drawn.kind)),
                   "any(…) draws from a list");
    if (are_vectors && parameter_.type != schema::ParameterType::kVector)
      return Error(
          scenario::kWrongKind,
          fmt::format("'{}' is a number and cannot be drawn from vectors", parameter_.name));
    if (are_vectors) return drawn;
    if (!TableInDomain(drawn) || !Reachable(drawn)) return std::nullopt;
    for (Value& argument : drawn.arguments) argument = AsNumber(argument)->AsReal();
    return drawn;
  }

  std::nullopt_t WrongKind(const Value& value) const {
    const schema::Text* text = AsText(value);
    if (text != nullptr &&
        (parameter_.HasWord(text->text, plugins_) || parameter_.TakesCall(text->text)))
      return Error(scenario::kWrongKind,
                   fmt::format("'{}' takes a word, not a text", parameter_.name),
                   fmt::format("write {} without quotes", text->text));
    return Error(scenario::kWrongKind,
                 fmt::format("'{}' takes {}, but this is {}", parameter_.name,
                             parameter_.Takes(plugins_), names::KindName(value)),
                 InsteadOf(value));
  }

  /// What to write instead of a value of another kind; empty if that is unknown.
  std::string InsteadOf(const Value& value) const {
    if (AsText(value) != nullptr && parameter_.TakesCall("mesh"))
      return fmt::format("write mesh({})", ToText(value));
    if (const schema::Number* number = AsNumber(value);
        number != nullptr && parameter_.type == schema::ParameterType::kSwitch)
      return number->AsReal() == 0 ? "write off" : "write on";
    const Eigen::Vector3d* vector = AsVector(value);
    if (vector == nullptr) return {};
    const auto joined = [&](const char* separator) {
      return fmt::format("{0:}{3}{1:}{3}{2:}", vector->x(), vector->y(), vector->z(), separator);
    };
    if (parameter_.TakesCall("at")) return fmt::format("write at({})", joined(", "));
    const bool may_be_sides = vector->minCoeff() > 0;
    if (may_be_sides && parameter_.type == schema::ParameterType::kRatio)
      return fmt::format("write {}", joined(" : "));
    if (may_be_sides && schema::GroupParameter("size").get() == &parameter_)
      return fmt::format("write size {}; aspect 1 : {} : {}", vector->x(),
                         vector->y() / vector->x(), vector->z() / vector->x());
    if (parameter_.type == schema::ParameterType::kReal ||
        parameter_.type == schema::ParameterType::kCount)
      return fmt::format("one number: {}", parameter_.doc);
    return {};
  }

  bool InDomain(double value, const std::string& text) const {
    if (parameter_.domain.Contains(value)) return true;
    Error(scenario::kOutOfDomain,
          fmt::format("'{}' must be {}, not {}", parameter_.name, parameter_.domain.Text(), text),
          value == 0 && parameter_.HasWord("fixed") ? "write mass fixed for objects that never move"
                                                    : "");
    return false;
  }

  std::optional<Value> FromCount(const Value& value) const {
    if (!AsNumber(value)) return WrongKind(value);
    const auto whole = AsNumber(value)->AsWhole();
    if (!whole)
      return Error(scenario::kWrongKind, fmt::format("'{}' must be a whole number, not {}",
                                                     parameter_.name, AsNumber(value)->Text()));
    constexpr Integer kMost = ~std::uint64_t{0};
    if (*whole > kMost || !parameter_.domain.Contains(static_cast<double>(*whole)))
      return Error(scenario::kOutOfDomain,
                   *whole > 0 ? fmt::format("'{}' cannot be as large as {}", parameter_.name,
                                            AsNumber(value)->Text())
                              : fmt::format("'{}' must be {}, not {}", parameter_.name,
                                            parameter_.domain.Text(), AsNumber(value)->Text()));
    return Value(static_cast<std::uint64_t>(*whole));
  }

  std::optional<Value> FromFormula(const Value& value) const {
    if (parameter_.type == schema::ParameterType::kReal &&
        (parameter_.distribution || parameter_.is_formula))
      return value;
    RefuseFormula(*AsFormula(value), diagnostics_);
    return std::nullopt;
  }

  std::optional<Value> FromVector(const Value& value) const {
    const auto not_zero = [this](const Eigen::Vector3d& vector) {
      if (!parameter_.domain.not_zero || !vector.isZero(0)) return std::optional(Value(vector));
      return std::optional<Value>(
          Error(scenario::kOutOfDomain, fmt::format("'{}' must not be 0", parameter_.name)));
    };
    if (AsVector(value)) return not_zero(*AsVector(value));
    if (!AsNumber(value)) return WrongKind(value);
    if (AsNumber(value)->AsReal() != 0)
      return Error(scenario::kWrongKind,
                   fmt::format("'{}' is a vector; the only number allowed in its place is 0",
                               parameter_.name),
                   fmt::format("write (0, {}, 0), for example", AsNumber(value)->Text()));
    return not_zero(Eigen::Vector3d::Zero());
  }

  std::optional<Value> FromWord(const schema::Word& word) const {
    const std::string& text = word.text;
    if (parameter_.type == schema::ParameterType::kSwitch) {
      if (text == "on" || text == "true") return Value(true);
      if (text == "off" || text == "false") return Value(false);
    }
    if (parameter_.TakesDetectors())
      if (const auto detector = schema::FindDetector(text, plugins_))
        return CanBeUsed(*detector) ? std::optional(Value(word)) : std::nullopt;
    if (parameter_.HasWord(text)) return Value(word);
    // The existence of groups and joints is checked with the whole scene.
    if (schema::AreNamesOfScene(parameter_.word_source)) return Value(word);
    if (parameter_.TakesCall(text)) {
      const schema::ParametrisedWord& info = *schema::FindParametrisedWord(text);
      if (auto call = schema::WithDefaults(info)) return Value(std::move(*call));
      ReportMissingArguments(info, schema::RequiredArguments(info), span_, diagnostics_);
      return std::nullopt;
    }
    std::vector<std::string_view> words = parameter_.AllWords(plugins_);
    for (const std::string_view call : parameter_.AllCalls()) words.push_back(call);
    if (parameter_.type == schema::ParameterType::kSwitch) words.insert(words.end(), {"on", "off"});
    if (words.empty())
      return Error(
          scenario::kUnknownName, fmt::format("'{}' cannot be '{}'", parameter_.name, text),
          fmt::format("it takes {}, and no let has this name", parameter_.Takes(plugins_)));
    std::string_view near = dsl::DidYouMean(text, words);
    if (std::ranges::find(words, schema::WordFor(text)) != words.end())
      near = schema::WordFor(text);
    std::string help = near.empty() ? fmt::format("it takes {}", parameter_.Takes(plugins_))
                                    : fmt::format("did you mean '{}'?", near);
    if (near.empty() && parameter_.word_source == schema::WordSource::kObjectTypes)
      for (const schema::Parameter& other : schema::Schema())
        if (!other.grouped && schema::ListsWord(other.also, text))
          help = fmt::format("did you mean '{}', {}?", other.FullName(),
                             other.doc.substr(0, other.doc.find(';')));
    if (parameter_.TakesDetectors() && plugins_.empty())
      help +=
          fmt::format("{}our own detector needs --plugin FILE.so, or `use detector \"FILE.so\"`",
                      near.empty() ? "; y" : " Y");
    return Error(scenario::kUnknownName, fmt::format("'{}' cannot be '{}'", parameter_.name, text),
                 std::move(help));
  }

  /// True if the detector has the required phase and is available.
  bool CanBeUsed(const schema::DetectorInfo& detector) const {
    if (!parameter_.HasWord(detector.name, plugins_)) {
      if (parameter_.word_source == schema::WordSource::kNarrowPhases) {
        Error(scenario::kWrongKind,
              fmt::format("'{}' has no narrow phase: it only finds pairs", detector.name),
              fmt::format("write detector {}", detector.name));
      } else {
        Error(scenario::kWrongKind,
              fmt::format("'{}' does not find pairs: it is a narrow phase", detector.name),
              fmt::format("write narrow_phase {}", detector.name));
      }
      return false;
    }
    const schema::DetectorPart* part = schema::FindDetectorPart(detector.part);
    if (part == nullptr || part->is_built) return true;
    Error(scenario::kUnavailable,
          fmt::format("'{}' is not part of this build: it needs the package {}", detector.name,
                      part->package),
          "`./setup --third-party` installs it and builds the detectors that need it");
    return false;
  }

  /// A measured value outside the domain is an error in the table.
  bool TableInDomain(const schema::Distribution& drawn) const {
    if (drawn.kind != schema::DistributionKind::kEmpirical) return true;
    return std::ranges::all_of(drawn.arguments, [&](const Value& value) {
      const schema::Number& number = *AsNumber(value);
      if (parameter_.domain.Contains(number.AsReal())) return true;
      Error(scenario::kOutOfDomain,
            fmt::format("'{}' must be {}, but '{}' has {}", parameter_.name,
                        parameter_.domain.Text(), drawn.file, number.Text()));
      return false;
    });
  }

  /// Draws outside the domain are repeated, which must terminate.
  bool Reachable(const schema::Distribution& drawn) const {
    const schema::Domain& domain = parameter_.domain;
    schema::Limits allowed{domain.min, domain.max};
    if (drawn.limits) {
      allowed.least = std::max(allowed.least, drawn.limits->least);
      allowed.most = std::min(allowed.most, drawn.limits->most);
    }
    const double chance = schema::ChanceWithin(drawn, allowed.least, allowed.most);
    if (chance >= kLeastChance) return true;
    const char* how_often = chance > 0 ? "hardly ever" : "never";
    const std::string text = LabelOf(Value(drawn));
    Error(scenario::kOutOfDomain,
          drawn.limits ? fmt::format("{} {} draws a value within its limits that is {}", text,
                                     how_often, domain.Text())
                       : fmt::format("'{}' must be {}; {} {} is", parameter_.name, domain.Text(),
                                     text, how_often),
          "values outside are drawn again, so most of the distribution must lie inside");
    return false;
  }

  const schema::Parameter& parameter_;
  const text::Span& span_;
  const std::vector<text::Span>& choices_;
  std::span<const schema::PluginDetector> plugins_;
  dsl::Diagnostics& diagnostics_;
};

}  // namespace

std::optional<Value> Convert(const Value& value, const schema::Parameter& parameter,
                             const text::Span& span, const std::vector<text::Span>& choices,
                             std::span<const schema::PluginDetector> plugins,
                             dsl::Diagnostics& diagnostics) {
  const Converter converter(parameter, span, choices, plugins, diagnostics);
  return AsDistribution(value) ? converter.Drawn(*AsDistribution(value))
                               : converter.Constant(value);
}

void ReportMissingArguments(const schema::ParametrisedWord& info,
                            const std::vector<std::string_view>& missing, const text::Span& span,
                            dsl::Diagnostics& diagnostics) {
  std::string usage;
  for (const std::string_view name : schema::RequiredArguments(info))
    usage += fmt::format("{}{}", usage.empty() ? "" : ", ",
                         info.takes_parts ? std::string("part(…)") : fmt::format("{}: …", name));
  diagnostics.Report(scenario::kBadArguments, span,
                     fmt::format("'{}' needs {}", info.name, fmt::join(missing, ", ")),
                     fmt::format("write {}({})", info.name, usage));
}

std::optional<Value> ConvertList(const std::vector<std::pair<Value, text::Span>>& values,
                                 const schema::Parameter& parameter,
                                 dsl::Diagnostics& diagnostics) {
  schema::WordList words;
  std::vector<text::Span> spans;
  bool good = true;
  for (const auto& [item, span] : values) {
    const auto value = Converter(parameter, span, {}, {}, diagnostics).Constant(item);
    if (!value) {
      good = false;
      continue;
    }
    const std::string& word = std::get<schema::Word>(*value).text;
    if (std::ranges::find(words, word) != words.end()) {
      diagnostics.Report(scenario::kSetTwice, span,
                         fmt::format("'{}' is in the list already", word), "keep one of them");
      good = false;
    }
    words.push_back(word);
    spans.push_back(span);
  }
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!parameter.StandsAlone(words[i])) continue;
    // If two words each exclude all others, the second is reported.
    for (std::size_t j = 0; j < words.size(); ++j) {
      if (words[j] == words[i] || (parameter.StandsAlone(words[j]) && i < j) ||
          parameter.StandsBeside(words[i], words[j]))
        continue;
      diagnostics.Report(
          scenario::kContradiction, spans[i],
          fmt::format("'{}' cannot be combined with '{}'", words[i], words[j]),
          fmt::format("'{}' applies to all of them: write it alone, or only the others", words[i]));
      good = false;
      break;
    }
  }
  if (!good) return std::nullopt;
  // The order has no meaning, so it must not change the id of the run.
  std::ranges::sort(words);
  return Value(std::move(words));
}

namespace {

using schema::Formula;

/// The names of settings in a formula, also in one that is the argument of same( ) or density( ).
std::vector<const Formula*> NamesIn(const Value& value) {
  const schema::Call* call = AsCall(value);
  if (call == nullptr) return schema::SettingsIn(value);
  std::vector<const Formula*> names;
  for (const Value& argument : call->arguments)
    for (const Formula* name : schema::SettingsIn(argument)) names.push_back(name);
  return names;
}

}  // namespace

bool IsDrawnForEachObject(const Value& value) {
  const schema::Call* call = AsCall(value);
  return AsDistribution(value) || AsFormula(value) ||
         (call != nullptr && (call->name == "same" || call->name == "density"));
}

std::optional<Value> NamedSetting(const dsl::Expr& path, const scenario::ParameterKey& key,
                                  const Value& value, Evaluator& evaluator) {
  const auto refuse = [&](std::string message, std::string help = {}) {
    return evaluator.Error(scenario::kWrongKind, path.span, std::move(message), std::move(help));
  };
  if (key.first.empty() || key.second->type != schema::ParameterType::kReal)
    return refuse(fmt::format("'{}' is drawn for each object and has no single value", path.text));
  const schema::Distribution* drawn = AsDistribution(value);
  if (drawn != nullptr && key.second == schema::GroupParameter("size").get())
    return refuse(
        fmt::format("'{}' draws each side separately, so that an object has no single size",
                    path.text),
        fmt::format("write size same({})", LabelOf(value)));
  if (drawn != nullptr)
    for (const Value& choice : drawn->arguments)
      if (AsWord(choice))
        return refuse(fmt::format("'{}' can be drawn as {}, which is not a number", path.text,
                                  LabelOf(choice)));
  Formula formula;
  formula.setting = key.second->name;
  formula.group = key.first;
  formula.written = path.span;
  return formula;
}

Value Variable(const dsl::Expr& path) {
  Formula formula;
  formula.setting = path.text;
  formula.written = path.span;
  return formula;
}

std::optional<Value> MakeFormula(std::string op, std::vector<Value> arguments,
                                 const text::Span& span, Evaluator& evaluator) {
  Formula formula;
  formula.op = std::move(op);
  // As in a plan, which does not distinguish integers and reals here.
  for (Value& argument : arguments)
    formula.arguments.push_back(AsNumber(argument) ? Value(AsNumber(argument)->AsReal())
                                                   : std::move(argument));
  Value value = std::move(formula);
  if (schema::FormulaParts(value) <= schema::kMostFormulaParts) return value;
  return evaluator.Error(
      scenario::kWrongKind, span,
      fmt::format("an expression of drawn values or variables has at most {} numbers, names and "
                  "operators",
                  schema::kMostFormulaParts));
}

void RefuseFormula(const Formula& formula, dsl::Diagnostics& diagnostics) {
  const Value value = formula;
  const Formula& name = *schema::SettingsIn(value).front();
  diagnostics.Report(scenario::kWrongKind, name.written,
                     fmt::format("'{}' is drawn for each object and has no single value",
                                 text::TextOf(name.written)));
}

std::optional<Value> OfOwnGroup(Value value, const scenario::ParameterKey& key,
                                Evaluator& evaluator) {
  if (key.first.empty()) return value;  // any formula is an error in the world
  for (const Formula* name : NamesIn(value)) {
    if (name->group == key.first || name->group.empty()) continue;  // without one: a variable
    const schema::Parameter* parameter = schema::FindParameter(name->setting, true);
    // `size pebbles.size` is a same( ) like that of the other group, but with separate draws.
    if (AsFormula(value) && AsFormula(value)->op.empty())
      if (auto other = evaluator.EvaluateParameter({name->group, parameter});
          other && AsCall(*other))
        return other;
    return evaluator.Error(
        scenario::kWrongKind, name->written,
        fmt::format(
            "'{}' is drawn for each object of '{}', and has no single value for those of '{}'",
            text::TextOf(name->written), name->group, key.first),
        "an expression can name drawn settings of its own group only");
  }
  return value;
}

}  // namespace cdb::evaluate
