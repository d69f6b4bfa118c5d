#include "compiler/expand.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "compiler/checks/lint_findings.h"
#include "compiler/checks/scene_checks.h"
#include "compiler/checks/scene_faults.h"
#include "compiler/evaluate/configuration.h"
#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/dependencies.h"
#include "compiler/evaluate/ranges.h"
#include "compiler/plan/reference.h"
#include "compiler/plan/requested_errors.h"
#include "compiler/plan/trace.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/result_names.h"

namespace cdb::compiler {
namespace {

constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);
/// What an axis holds in a case that has no value for it.
constexpr std::string_view kNoValue = "none";

/// An axis of the plan: a sweep under one name in every configuration, or the names of cases.
struct GridAxis {
  plan::Axis axis;
  std::pair<int, int> order;
  const evaluate::SweepAxis* sweep = nullptr;  ///< one of those it was made from; null for cases
  std::size_t case_axis = kNowhere;
  std::vector<std::vector<plan::Coordinate>> values;  ///< by configuration
};

class Expander {
 public:
  Expander(const scenario::Scenario& scenario, const scenario::BenchmarkRef& benchmark,
           const plan::FindSceneFault& find_fault, dsl::Diagnostics& diagnostics, bool lints)
      : scenario_(scenario),
        benchmark_(benchmark),
        diagnostics_(diagnostics),
        lints_(lints),
        errors_before_(diagnostics.error_count()),
        layered_(scenario, benchmark, diagnostics),
        checks_(benchmark.benchmark->name.span, diagnostics),
        faults_(benchmark.benchmark->name.span, find_fault, diagnostics),
        findings_(benchmark.benchmark->name.span, diagnostics) {}

  std::optional<plan::Plan> Run() {
    if (!layered_.is_readable() || !Configure()) return std::nullopt;
    MakeAxes();
    CheckAxisNames({});
    const bool countable = !Failed() && layered_.is_complete() && !HasUnreadSkip();
    if (!countable || !CountRuns()) {
      // No grid, but each setting can still be looked at.
      for (const auto& configuration : configurations_) configuration->CheckSettings();
      return std::nullopt;
    }
    MakeRuns();
    if (Failed() || broken_) return std::nullopt;
    CheckAxisNames(plan::ErrorsOf(plan_));
    if (Failed()) return std::nullopt;
    plan::AddReferences(plan_);
    if (plan_.runs.empty()) {
      diagnostics_.Report(scenario::kNoRuns, benchmark_.benchmark->name.span,
                          fmt::format("'{}' has no run left", benchmark_.benchmark->name.text),
                          "its `skip` leaves out every point");
      return std::nullopt;
    }
    faults_.Report(plan_.runs.size());
    findings_.Report(plan_.runs.size());
    if (Failed()) return std::nullopt;
    return std::move(plan_);
  }

 private:
  bool Failed() const { return diagnostics_.error_count() > errors_before_; }

  bool TooMany(double count, const dsl::Span& span) {
    diagnostics_.Report(
        scenario::kTooManyRuns, span, fmt::format("this benchmark has {:.6g} runs", count),
        fmt::format("a plan holds at most {}; leave some out by `skip` or split the "
                    "benchmark",
                    evaluate::kMaxRuns));
    return false;
  }

  bool Configure() {
    double count = 1;
    for (const scenario::CaseAxis& axis : layered_.case_axes()) {
      case_extents_.push_back(axis.names.size());
      count *= static_cast<double>(axis.names.size());
    }
    if (count > static_cast<double>(evaluate::kMaxRuns))
      return TooMany(count, benchmark_.benchmark->name.span);
    evaluate::Point chosen(case_extents_.size(), 0);
    do {
      configurations_.push_back(
          std::make_unique<evaluate::Configuration>(scenario_, layered_.Lay(chosen), diagnostics_));
    } while (evaluate::Advance(chosen, case_extents_));
    return true;
  }

  /// Then points that it leaves out cannot be told from others.
  bool HasUnreadSkip() const {
    return std::ranges::any_of(configurations_, [](const auto& configuration) {
      return std::ranges::any_of(configuration->layers().skips,
                                 [](const auto& skip) { return !skip.node->when; });
    });
  }

  void MakeAxes() {
    for (std::size_t i = 0; i < layered_.case_axes().size(); ++i) {
      const scenario::CaseAxis& cases = layered_.case_axes()[i];
      GridAxis axis;
      axis.axis.name = cases.name;
      axis.axis.values.assign(cases.names.begin(), cases.names.end());
      axis.order = {cases.order, -1};
      axis.case_axis = i;
      grid_.push_back(std::move(axis));
    }
    for (const auto& configuration : configurations_)
      for (const evaluate::SweepAxis& sweep : configuration->axes()) Merge(sweep);
    std::ranges::stable_sort(grid_, {}, &GridAxis::order);
    for (GridAxis& axis : grid_)
      if (axis.sweep != nullptr) FillValues(axis);
  }

  void Merge(const evaluate::SweepAxis& sweep) {
    for (GridAxis& axis : grid_) {
      if (axis.axis.name != sweep.name) continue;
      if (axis.sweep == nullptr) {
        diagnostics_.Report(scenario::kAxisTwice, sweep.span,
                            fmt::format("there are cases called '{}' already", sweep.name),
                            fmt::format("name the axis: sweep(…) as {}_2", sweep.name));
      } else {
        axis.order = std::min(axis.order, sweep.order);
      }
      return;
    }
    GridAxis axis;
    axis.axis.name = sweep.name;
    axis.axis.parameter = sweep.parameter;
    axis.axis.unit = sweep.unit;
    axis.order = sweep.order;
    axis.sweep = &sweep;
    grid_.push_back(std::move(axis));
  }

  /// An axis is a variable of the results, so it cannot have the name of another.
  void CheckAxisNames(const std::vector<const schema::ErrorInfo*>& errors) {
    for (const GridAxis& axis : grid_) {
      const std::string& name = axis.axis.name;
      const auto clash = schema::FindNameClash(name, errors);
      if (!clash) continue;
      const bool is_cases = axis.sweep == nullptr;
      diagnostics_.Report(
          scenario::kReservedName,
          is_cases ? layered_.case_axes()[axis.case_axis].span : axis.sweep->span,
          fmt::format("an axis cannot be called '{}', which is {}", name, *clash),
          is_cases ? fmt::format("give the cases another name: cases {}_case {{ … }}", name)
                   : fmt::format("give the axis another name: sweep(…) as {}_value", name));
    }
  }

  /// The axis holds every value that it has in some case; where it is not swept, the one that
  /// stands there.
  void FillValues(GridAxis& axis) {
    for (const auto& configuration : configurations_) {
      std::vector<plan::Coordinate> here;
      const auto swept =
          std::ranges::find(configuration->axes(), axis.axis.name, &evaluate::SweepAxis::name);
      if (swept != configuration->axes().end()) {
        here = swept->values;
      } else {
        const auto value = configuration->ConstantFor(*axis.sweep);
        here.push_back(value ? evaluate::CoordinateOf(*value) : std::string(kNoValue));
      }
      axis.values.push_back(std::move(here));
    }
    bool text = false;
    for (const auto& here : axis.values)
      for (const plan::Coordinate& value : here) text = text || value.index() == 1;
    for (auto& here : axis.values) {
      for (plan::Coordinate& value : here) {
        if (text && value.index() == 0) value = schema::FormatReal(std::get<double>(value));
        if (std::ranges::find(axis.axis.values, value) == axis.axis.values.end())
          axis.axis.values.push_back(value);
      }
    }
  }

  bool CountRuns() {
    double count = 1;
    for (const GridAxis& axis : grid_) {
      extents_.push_back(axis.axis.values.size());
      count *= static_cast<double>(axis.axis.values.size());
      plan_.axes.push_back(axis.axis);
    }
    const schema::Parameter* repeats = schema::WorldParameter("repeats").get();
    std::optional<std::uint64_t> value;
    for (const auto& configuration : configurations_) {
      const dsl::Span span = configuration->SpanOf({"", repeats}, benchmark_.benchmark->name.span);
      evaluate::Configuration& here = *configuration;
      if (!evaluate::Dependencies({"", repeats}, here.layers(), here.axes(), here.evaluator())
               .empty()) {
        const dsl::Span whole = here.layers().settings.at({"", repeats}).node->values[0]->span;
        diagnostics_.Report(scenario::kMisplacedSweep, whole, "'repeats' cannot be swept",
                            "every point has as many: they are the axis `rep`");
        return false;
      }
      auto setting = here.evaluator().EvaluateParameter({"", repeats});
      if (setting) setting = evaluate::Convert(*setting, *repeats, span, {}, {}, diagnostics_);
      if (!setting) return false;
      const std::uint64_t n = std::get<schema::Number>(*setting).AsCount();
      if (value && *value != n) {
        diagnostics_.Report(scenario::kWrongPlace, span, "'repeats' is the same in every case",
                            "set it outside the cases");
        return false;
      }
      value = n;
    }
    plan_.repeats = *value;
    count *= static_cast<double>(*value);
    return count <= static_cast<double>(evaluate::kMaxRuns) ||
           TooMany(count, benchmark_.benchmark->name.span);
  }

  void MakeRuns() {
    evaluate::Point at(grid_.size(), 0);
    do {
      std::size_t chosen = 0;
      for (std::size_t i = 0; i < layered_.case_axes().size(); ++i)
        for (std::size_t a = 0; a < grid_.size(); ++a)
          if (grid_[a].case_axis == i) chosen = chosen * case_extents_[i] + at[a];
      if (!MakeRun(at, chosen)) plan_.skipped.push_back(at);
    } while (evaluate::Advance(at, extents_));
  }

  /// False where the point is left out.
  bool MakeRun(const evaluate::Point& at, std::size_t chosen) {
    evaluate::Configuration& configuration = *configurations_[chosen];
    evaluate::Point local(configuration.axes().size(), 0);
    for (std::size_t a = 0; a < grid_.size(); ++a) {
      if (grid_[a].sweep == nullptr) continue;
      const auto& here = grid_[a].values[chosen];
      const auto value = std::ranges::find(here, grid_[a].axis.values[at[a]]);
      if (value == here.end()) return false;
      const auto swept =
          std::ranges::find(configuration.axes(), grid_[a].axis.name, &evaluate::SweepAxis::name);
      if (swept != configuration.axes().end())
        local[static_cast<std::size_t>(swept - configuration.axes().begin())] =
            static_cast<std::size_t>(value - here.begin());
    }
    configuration.Choose(local);
    if (IsSkipped(configuration, at)) return false;
    auto scene = configuration.MakeScene();
    if (!scene || !checks_.Pass(configuration, *scene)) {
      broken_ = true;
      return true;
    }
    if (!plan::TraceOf(*scene)) {
      faults_.Add(configuration, *scene, plan_.repeats);
      if (lints_) findings_.Add(configuration, *scene, plan_.repeats);
    }
    for (std::uint64_t rep = 0; rep < plan_.repeats; ++rep)
      plan_.runs.push_back({plan::RunId(*scene, rep), at, rep, *scene, {}, {}});
    return true;
  }

  /// The values of an axis of words.
  static std::vector<std::string> WordsOf(const plan::Axis& axis) {
    std::vector<std::string> words;
    for (const plan::Coordinate& word : axis.values) words.push_back(std::get<std::string>(word));
    return words;
  }

  /// A coordinate for conditions: exact if all numbers of its axis are whole.
  static schema::Value ValueOf(const plan::Axis& axis, std::size_t index) {
    const auto* real = std::get_if<double>(&axis.values[index]);
    if (real == nullptr) return schema::Word{std::get<std::string>(axis.values[index])};
    if (axis.IsInteger()) return schema::Number::Whole(static_cast<schema::Integer>(*real));
    return *real;
  }

  bool IsSkipped(evaluate::Configuration& configuration, const evaluate::Point& at) {
    if (configuration.layers().skips.empty()) return false;
    evaluate::Conditions& conditions = configuration.conditions();
    for (std::size_t a = 0; a < grid_.size(); ++a) {
      const plan::Axis& axis = grid_[a].axis;
      conditions.SetAxis(axis.name, ValueOf(axis, at[a]));
      if (axis.IsText() && !conditions.HasAxisWords(axis.name))
        conditions.SetAxisWords(axis.name, WordsOf(axis));
    }
    bool skipped = false;
    for (const scenario::Placed<dsl::Skip>& skip : configuration.layers().skips)
      skipped = conditions.Hold(*skip.node->when, skip.scope) || skipped;
    return skipped;
  }

  const scenario::Scenario& scenario_;
  const scenario::BenchmarkRef& benchmark_;
  dsl::Diagnostics& diagnostics_;
  bool lints_;
  int errors_before_;
  scenario::LayeredBenchmark layered_;
  checks::SceneChecks checks_;
  checks::SceneFaults faults_;
  checks::LintFindings findings_;
  std::vector<std::size_t> case_extents_, extents_;
  std::vector<std::unique_ptr<evaluate::Configuration>> configurations_;
  std::vector<GridAxis> grid_;
  plan::Plan plan_;
  /// A point has an error, which another benchmark may have reported already.
  bool broken_ = false;
};

}  // namespace

std::optional<plan::Plan> Expand(const scenario::Scenario& scenario,
                                 const scenario::BenchmarkRef& benchmark,
                                 const plan::FindSceneFault& find_fault,
                                 dsl::Diagnostics& diagnostics, bool lints) {
  return Expander(scenario, benchmark, find_fault, diagnostics, lints).Run();
}

}  // namespace cdb::compiler
