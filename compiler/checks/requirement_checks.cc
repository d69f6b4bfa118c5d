#include "compiler/checks/requirement_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string>
#include <utility>

#include "compiler/analysis/recorded.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/trace.h"
#include "compiler/evaluate/dimensions.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/evaluate/sweeps.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/series.h"
#include "compiler/schema/verdicts.h"
#include "dsl/text/source.h"

namespace cdb::checks {
namespace {

using dsl::Condition;
using dsl::ConditionKind;
using dsl::Expr;
using dsl::ExprKind;
using Words = std::vector<std::string_view>;

constexpr std::string_view kError = "error";

/// The text of a span, with a single space where it has several or a line end.
std::string Written(const text::Span& span) {
  std::string text;
  for (const char c : text::TextOf(span)) {
    const bool is_space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!is_space)
      text += c;
    else if (!text.empty() && text.back() != ' ')
      text += ' ';
  }
  return text;
}

bool IsPhase(std::string_view name) {
  return std::ranges::find(schema::kPhases, name) != std::end(schema::kPhases);
}

Words SeriesNames() {
  Words names;
  for (const schema::Series& series : schema::kSeries)
    if (series.shape == schema::SeriesShape::kScalar) names.push_back(series.name);
  return names;
}

Words ErrorNames() {
  Words names;
  for (const schema::ErrorInfo& error : schema::Errors()) names.push_back(error.name);
  return names;
}

/// Every statistic, of times or of series, and `error`.
Words FunctionNames() {
  Words names(std::begin(plan::kCycleStatistics), std::end(plan::kCycleStatistics));
  names.push_back(plan::kFinal);
  names.push_back(kError);
  return names;
}

Words VerdictWords() {
  Words words;
  for (const schema::VerdictInfo& info : schema::kVerdicts)
    if (info.verdict != schema::Verdict::kUnknown) words.push_back(info.name);
  return words;
}

/// `did you mean 'step'?`, or else `otherwise`.
std::string Nearest(std::string_view word, const Words& words, std::string otherwise) {
  const std::string_view nearest = dsl::DidYouMean(word, words);
  return nearest.empty() ? std::move(otherwise) : fmt::format("did you mean '{}'?", nearest);
}

/// The figure that an expression is; nullopt if it is none.
std::optional<plan::Figure> FigureOf(const Expr& expr) {
  if (expr.kind == ExprKind::kPath) return plan::FindFigure(expr.text);
  const bool is_of_one = expr.kind == ExprKind::kCall && expr.arguments.size() == 1 &&
                         !expr.arguments[0].name && !expr.arguments[0].weight &&
                         expr.arguments[0].value->kind == ExprKind::kPath;
  if (!is_of_one) return std::nullopt;
  return plan::FindFigure(fmt::format("{}({})", expr.text, expr.arguments[0].value->text));
}

/// Reads the requirements of one choice of cases.
class Reader {
 public:
  Reader(configure::Configuration& configuration, std::uint64_t repeats)
      : configuration_(configuration),
        evaluator_(configuration.evaluator()),
        dimensions_(configuration.layers(), evaluator_),
        repeats_(repeats) {}

  std::optional<WrittenRequirement> ReadOne(const Condition& condition,
                                            const scenario::Scope& scope) {
    what_ = "the condition of find()";
    if (condition.kind != ConditionKind::kCompare) {
      Error(scenario::kBadComparison, condition.span, "find() looks for one comparison",
            "write a benchmark for each; verdicts are ordered: verdict >= penetrating");
      return std::nullopt;
    }
    if (!ReadComparison(condition, scope)) return std::nullopt;
    plan::Requirement& until = found_[0].what;
    // A name does not say what was searched.
    if (until.figure.kind != plan::FigureKind::kVerdict &&
        std::ranges::none_of(until.text, [](char c) { return c >= '0' && c <= '9'; }))
      until.text += fmt::format(" ({}{}{})", schema::FormatReal(until.limit),
                                until.figure.Unit().empty() ? "" : " ", until.figure.Unit());
    return std::move(found_[0]);
  }

  std::optional<std::vector<WrittenRequirement>> ReadAll() {
    bool is_sound = true;
    for (const auto& placed : configuration_.layers().requirements)
      is_sound = placed.node->what != nullptr && Read(*placed.node->what, placed.scope) && is_sound;
    if (!is_sound) return std::nullopt;
    return std::move(found_);
  }

 private:
  bool Error(const dsl::DiagnosticKind& kind, const text::Span& span, std::string message,
             std::string help = {}) {
    evaluator_.Error(kind, span, std::move(message), std::move(help));
    return false;
  }

  bool Read(const Condition& condition, const scenario::Scope& scope) {
    switch (condition.kind) {
      case ConditionKind::kAnd: {
        const bool is_sound = Read(*condition.items[0], scope);
        return Read(*condition.items[1], scope) && is_sound;
      }
      case ConditionKind::kOr:
        return Error(scenario::kBadComparison, condition.span,
                     "'or' is not possible in a requirement",
                     "write a benchmark for each of them, or one requirement that holds for both");
      case ConditionKind::kNot:
        return Error(scenario::kBadComparison, condition.span,
                     "'not' is not possible in a requirement", "write the opposite comparison");
      case ConditionKind::kIn:
        return Error(scenario::kBadComparison, condition.span,
                     "'in' is not possible in a requirement",
                     "verdicts are ordered, the worst last: verdict <= penetrating");
      case ConditionKind::kCompare:
        return ReadComparison(condition, scope);
    }
    return false;
  }

  bool ReadComparison(const Condition& condition, const scenario::Scope& scope) {
    const auto left = FigureOf(*condition.left), right = FigureOf(*condition.right);
    if (left && right)
      return Error(scenario::kBadComparison, condition.span,
                   "two figures cannot be compared with each other", "compare each with a value");
    if (!left && !right) {
      const bool is_right =
          condition.left->kind != ExprKind::kPath && condition.left->kind != ExprKind::kCall &&
          (condition.right->kind == ExprKind::kPath || condition.right->kind == ExprKind::kCall);
      return ReportFigure(is_right ? *condition.right : *condition.left);
    }
    plan::Requirement what;
    what.text = Written(condition.span);
    what.figure = left ? *left : *right;
    what.comparison = *plan::FindComparison(condition.op);
    if (right) what.comparison = plan::Reversed(what.comparison);
    const Expr& figure = left ? *condition.left : *condition.right;
    const Expr& limit = left ? *condition.right : *condition.left;
    const bool is_equality = what.comparison == plan::Comparison::kEqual ||
                             what.comparison == plan::Comparison::kNotEqual;
    if (what.figure.IsMeasured() && is_equality)
      return Error(scenario::kBadComparison, condition.span,
                   fmt::format("'{}' is measured, and never equals a value", what.figure.Text()),
                   "use < or >");
    const auto value = what.figure.kind == plan::FigureKind::kVerdict
                           ? VerdictOf(limit)
                           : LimitOf(what.figure, limit, scope);
    if (!value) return false;
    what.limit = *value;
    if (what.figure.IsMeasured() && repeats_ < plan::kLeastRepeats)
      evaluator_.Error(scenario::kNoEffect, condition.span,
                       fmt::format("{} not tell whether this is met",
                                   repeats_ == 1 ? "one repeat does" : "so few repeats do"),
                       fmt::format("`repeats {}` or more give an interval", plan::kLeastRepeats));
    found_.push_back({std::move(what), condition.span, figure.span});
    return true;
  }

  std::optional<double> VerdictOf(const Expr& expr) {
    const Words words = VerdictWords();
    if (expr.kind == ExprKind::kPath)
      for (const schema::VerdictInfo& info : schema::kVerdicts)
        if (info.name == expr.text && info.verdict != schema::Verdict::kUnknown)
          return static_cast<double>(info.verdict);
    Error(scenario::kUnknownName, expr.span,
          fmt::format("there is no verdict '{}'", Written(expr.span)),
          Nearest(expr.text, words, fmt::format("verdicts are {}", fmt::join(words, ", "))));
    return std::nullopt;
  }

  std::optional<double> LimitOf(const plan::Figure& figure, const Expr& expr,
                                const scenario::Scope& scope) {
    if (!configure::SweepsIn(expr, scope, configuration_.layers(), evaluator_).empty()) {
      Error(scenario::kMisplacedSweep, expr.span, fmt::format("{} cannot be swept", what_),
            "it has one limit for all points");
      return std::nullopt;
    }
    // Units of results that are not among those of the language.
    const std::string_view unit = figure.Unit();
    const std::string_view written = unit == "ns"      ? "s"
                                     : unit == "bytes" ? "B"
                                     : unit == "J"     ? "N m"
                                                       : unit;
    if (!dimensions_.CheckFor(figure.Text(), written, expr, scope)) return std::nullopt;
    const auto number = evaluator_.EvaluateNumber(expr, scope, "limits of requirements");
    if (!number) return std::nullopt;
    return unit == "ns" ? number->AsReal() * 1e9 : number->AsReal();
  }

  /// Reports that `expr` is not a figure, and the nearest that is; false.
  bool ReportFigure(const Expr& expr) {
    if (expr.kind == ExprKind::kPath) return ReportName(expr);
    if (expr.kind == ExprKind::kCall) return ReportCall(expr);
    return Error(scenario::kBadComparison, expr.span, "neither side is a figure of the results",
                 "for example: p99(step) < 4 ms, verdict == stable, error(energy) < 1 %");
  }

  bool ReportName(const Expr& expr) {
    const std::string& name = expr.text;
    const schema::Series* series = schema::FindSeries(name);
    if (IsPhase(name) || (series != nullptr && series->shape == schema::SeriesShape::kScalar))
      return Error(scenario::kWrongForm, expr.span,
                   fmt::format("'{}' has a value in each cycle, and needs a statistic", name),
                   IsPhase(name) ? fmt::format("write p99({0}), or mean({0})", name)
                                 : fmt::format("write max({0}), mean({0}) or final({0})", name));
    if (series != nullptr) return ReportSeries(expr, name);
    if (std::ranges::count(ErrorNames(), name) > 0)
      return Error(scenario::kWrongForm, expr.span, fmt::format("'{}' is an error", name),
                   fmt::format("write error({})", name));
    Words names = {"verdict"};
    for (const schema::RunScalarInfo& info : schema::kRunScalars) names.push_back(info.name);
    return Error(scenario::kUnknownName, expr.span, fmt::format("there is no figure '{}'", name),
                 Nearest(name, names,
                         "a figure is verdict, p99(PHASE), max(SERIES), error(NAME) or a fact of a "
                         "run, such as peak_rss"));
  }

  bool ReportSeries(const Expr& expr, const std::string& name) {
    return Error(scenario::kWrongForm, expr.span,
                 name == "duration"
                     ? std::string("the times of 'duration' are those of phases")
                     : fmt::format("'{}' has several values in each cycle, and no statistic", name),
                 name == "duration" ? "name the phase: step, detect, …" : "");
  }

  bool ReportCall(const Expr& expr) {
    const Words functions = FunctionNames();
    if (std::ranges::count(functions, expr.text) == 0)
      return Error(
          scenario::kUnknownName, expr.span, fmt::format("there is no statistic '{}'", expr.text),
          Nearest(expr.text, functions, fmt::format("there are {}", fmt::join(functions, ", "))));
    if (expr.arguments.size() != 1 || expr.arguments[0].value->kind != ExprKind::kPath)
      return Error(scenario::kBadArguments, expr.span,
                   fmt::format("'{}' takes the name of one {}", expr.text,
                               expr.text == kError ? "error" : "phase or series"));
    const Expr& argument = *expr.arguments[0].value;
    const std::string& name = argument.text;
    if (expr.text == kError) {
      const Words errors = ErrorNames();
      return Error(scenario::kUnknownName, argument.span,
                   fmt::format("there is no error '{}'", name),
                   Nearest(name, errors, fmt::format("errors are {}", fmt::join(errors, ", "))));
    }
    const schema::Series* series = schema::FindSeries(name);
    if (IsPhase(name))
      return Error(scenario::kWrongForm, expr.span, "a time has no final value",
                   fmt::format("write p99({0}), or mean({0})", name));
    if (series != nullptr && series->shape == schema::SeriesShape::kScalar)
      return Error(scenario::kWrongForm, expr.span,
                   fmt::format("'{}' is for times, and '{}' is none", expr.text, name),
                   fmt::format("write max({})", name));
    if (series != nullptr) return ReportSeries(argument, name);
    Words names(std::begin(schema::kPhases), std::end(schema::kPhases));
    const Words of_series = SeriesNames();
    names.insert(names.end(), of_series.begin(), of_series.end());
    return Error(scenario::kUnknownName, argument.span,
                 fmt::format("there is no phase or series '{}'", name),
                 Nearest(name, names,
                         fmt::format("phases are {}; series: cdb doc results",
                                     fmt::join(schema::kPhases, ", "))));
  }

  configure::Configuration& configuration_;
  evaluate::Evaluator& evaluator_;
  evaluate::Dimensions dimensions_;
  const std::uint64_t repeats_;
  std::string_view what_ = "a requirement";
  std::vector<WrittenRequirement> found_;
};

/// The first word of `record` that selects the series.
std::string_view RecordWordOf(const schema::Series& series) {
  return series.records.substr(0, series.records.find(' '));
}

}  // namespace

std::optional<std::vector<WrittenRequirement>> ReadRequirements(
    configure::Configuration& configuration, std::uint64_t repeats) {
  return Reader(configuration, repeats).ReadAll();
}

std::optional<WrittenRequirement> ReadUntil(configure::Configuration& configuration,
                                            const dsl::Condition& condition,
                                            const scenario::Scope& scope, std::uint64_t repeats) {
  return Reader(configuration, repeats).ReadOne(condition, scope);
}

std::optional<WrittenRace> ReadRace(configure::Configuration& configuration, const Expr& call,
                                    const scenario::Scope& scope) {
  evaluate::Evaluator& evaluator = configuration.evaluator();
  const evaluate::Sweep* sweep = evaluator.sweeps().Find(call, scope);
  if (sweep == nullptr) return std::nullopt;
  WrittenRace race = {{*plan::FindFigure("mean(step)"), sweep->tolerance}, call.span, call.span};
  for (const dsl::Argument& argument : call.arguments) {
    if (!argument.name || argument.name->text != evaluate::kBy) continue;
    race.figure = argument.value->span;
    const auto figure = FigureOf(*argument.value);
    if (!figure || figure->kind != plan::FigureKind::kTime) {
      evaluator.Error(
          scenario::kBadArguments, argument.value->span,
          "a race is by a time: a statistic over the cycles of a run, of a phase",
          fmt::format("for example: by: median(detect); statistics: {}; phases: {}",
                      fmt::join(plan::kCycleStatistics, ", "), fmt::join(schema::kPhases, ", ")));
      return std::nullopt;
    }
    race.what.by = *figure;
  }
  return race;
}

bool HasFigure(const plan::Scene& scene, const plan::Figure& figure) {
  switch (figure.kind) {
    case plan::FigureKind::kVerdict:
      return scene.world.Lists("record", "stability");
    case plan::FigureKind::kTime:
      // On a trace, only some phases take place.
      if (analysis::TraceOf(scene) && figure.name != "step" && figure.name != "detect" &&
          figure.name != (analysis::IsOnPairs(scene) ? "narrow" : "broad"))
        return false;
      return analysis::IsRecordedBy(*schema::FindSeries("duration"), scene);
    case plan::FigureKind::kSeries:
      return analysis::IsRecordedBy(*schema::FindSeries(figure.name), scene);
    case plan::FigureKind::kError: {
      const auto errors = analysis::ErrorsOf(scene);
      return std::ranges::find(errors, figure.name, &schema::ErrorInfo::name) != errors.end();
    }
    case plan::FigureKind::kScalar:
      return true;
  }
  return false;
}

void ReportNotRecorded(const WrittenRequirement& requirement, std::string_view benchmark,
                       dsl::Diagnostics& diagnostics) {
  const plan::Figure& figure = requirement.what.figure;
  std::string help;
  switch (figure.kind) {
    case plan::FigureKind::kVerdict:
      help = "verdicts need `record stability`";
      break;
    case plan::FigureKind::kTime:
      help = "times need `record timing`";
      break;
    case plan::FigureKind::kSeries:
      help = fmt::format("`record {}` has it", RecordWordOf(*schema::FindSeries(figure.name)));
      break;
    case plan::FigureKind::kError:
      help = fmt::format(
          "it needs `accuracy.metrics {}`",
          std::ranges::find(schema::Errors(), figure.name, &schema::ErrorInfo::name)->metric);
      break;
    case plan::FigureKind::kScalar:
      break;
  }
  diagnostics.Report(scenario::kNeeded, requirement.figure,
                     fmt::format("'{}' does not record {}", benchmark, figure.Text()),
                     std::move(help));
}

}  // namespace cdb::checks
