#include "compiler/compile.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/trace.h"
#include "compiler/block_maker.h"
#include "compiler/checks/file_lets.h"
#include "compiler/checks/idle_settings.h"
#include "compiler/checks/requirement_checks.h"
#include "compiler/configure/axes.h"
#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/sweeps.h"
#include "compiler/grid/survey.h"
#include "compiler/plan/input_file.h"
#include "compiler/plan/race_bounds.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/schema.h"
#include "dsl/text/check.h"

namespace cdb::compiler {
Compilation Compile(const std::string& path, const scenario::ReadFile& read,
                    const CompileOptions& options) {
  Compilation result;
  const auto scenario = std::make_shared<const scenario::Scenario>(
      path, options.library, read, options.plugins, options.read_trace, options.read_poses,
      options.read_model, options.read_robot, result.diagnostics);
  result.scenario = scenario;
  if (scenario->main() == nullptr) return result;
  const auto benchmarks = scenario->Benchmarks();
  const bool is_read = !result.diagnostics.has_errors();
  scenario->CheckNames(result.diagnostics);
  for (const scenario::BenchmarkRef& benchmark : benchmarks)
    result.benchmarks.push_back(benchmark.benchmark->name.text);
  if (benchmarks.empty() && is_read) {
    const text::Span start = {scenario->main()->tree.source.get(), 0, 0};
    result.diagnostics.Report(scenario::kNoRuns, start, "there is no benchmark in this file",
                              "`benchmark name { }` is a complete benchmark");
  }
  checks::CheckFileLets(*scenario, result.diagnostics);
  for (const scenario::BenchmarkRef& benchmark : benchmarks) {
    const bool is_asked_for =
        !options.benchmark || *options.benchmark == benchmark.benchmark->name.text;
    auto grid = Expand(scenario, benchmark, options.find_fault, result.diagnostics, is_asked_for);
    if (!grid || !is_asked_for) continue;
    checks::ReportUnreachable(*scenario, benchmark, *grid, result.diagnostics);
    if (options.lists_runs && grid->run_count() > kMostListed)
      result.diagnostics.Report(scenario::kTooManyRuns, benchmark.benchmark->name.span,
                                fmt::format("this benchmark has {} runs", grid->run_count()),
                                fmt::format("commands that list runs take at most {}; skip some by "
                                            "`skip`, or split the benchmark",
                                            kMostListed));
    grid->head.benchmark = benchmark.benchmark->name.text;
    grid->head.title = benchmark.benchmark->title;
    grid->head.source = path;
    grid->head.scenario_text = scenario->FullText();
    result.grids.push_back(std::move(*grid));
  }
  if (result.diagnostics.has_errors()) result.grids.clear();
  if (options.lists_runs)
    for (const grid::Grid& grid : result.grids) result.plans.push_back(grid::ListRuns(grid));
  return result;
}

std::optional<std::string> ReadFromDisk(const std::string& path, std::string& why) {
  return plan::ReadInputFile(path, why);
}

namespace {

/// Adds the plug-ins that the scene does not have yet.
void AddPlugins(std::span<const schema::PluginDetector> plugins, plan::Scene& scene) {
  for (const schema::PluginDetector& plugin : plugins)
    if (std::ranges::find(scene.plugins, plugin.name, &schema::PluginDetector::name) ==
        scene.plugins.end())
      scene.plugins.push_back(plugin);
  std::ranges::sort(scene.plugins, {}, &schema::PluginDetector::name);
}

}  // namespace

plan::Plan Cross(const plan::Plan& plan, schema::WorldParameter parameter,
                 const std::vector<std::string>& words,
                 std::span<const schema::PluginDetector> plugins) {
  CDB_CHECK(std::ranges::all_of(
      words, [&](const auto& word) { return (*parameter).HasWord(word, plugins); }));
  const std::string name(parameter.name());
  if (std::ranges::find(plan.axes, name, &plan::Axis::parameter) != plan.axes.end()) return plan;
  plan::Plan crossed = plan;
  plan::Axis axis{name, name, std::string((*parameter).unit), {}};
  axis.values.assign(words.begin(), words.end());
  crossed.axes.insert(crossed.axes.begin(), std::move(axis));
  crossed.runs.clear();
  crossed.skipped.clear();
  for (std::size_t i = 0; i < words.size(); ++i) {
    for (plan::Run run : plan.runs) {
      run.at.insert(run.at.begin(), i);
      run.scene.world.Set(parameter, schema::Word{words[i]});
      AddPlugins(plugins, run.scene);
      run.scene.KeepUsedPlugins();
      run.id = plan::RunId(run.scene, run.rep);
      crossed.runs.push_back(std::move(run));
    }
    for (std::vector<std::size_t> at : plan.skipped) {
      at.insert(at.begin(), i);
      crossed.skipped.push_back(std::move(at));
    }
  }
  analysis::AddReferences(crossed);
  return crossed;
}

namespace {

constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);
/// The maximum number of choices of cases, each of which is laid out separately.
constexpr double kMostCases = 100'000;
/// The maximum number of points of a grid: the results have a cell for each, also for skipped ones.
constexpr double kMostPoints = 1e9;
/// The coordinate of a case that has no value for an axis.
constexpr std::string_view kNoValue = "none";

/// An axis of the plan: a sweep that has this name in every configuration, or the names of cases.
struct GridAxis {
  plan::Axis axis;
  std::pair<int, int> order;
  const configure::SweepAxis* sweep = nullptr;  ///< one of its sweeps; null for cases
  std::size_t case_axis = kNowhere;
  std::vector<std::vector<plan::Coordinate>> values;        ///< by configuration
  std::unordered_map<plan::Coordinate, std::size_t> index;  ///< of each value
};

class Expander {
 public:
  Expander(std::shared_ptr<const scenario::Scenario> scenario,
           const scenario::BenchmarkRef& benchmark, const analysis::FindSceneFault& find_fault,
           dsl::Diagnostics& diagnostics, bool lints)
      : scenario_(std::move(scenario)),
        benchmark_(benchmark),
        find_fault_(find_fault),
        diagnostics_(diagnostics),
        lints_(lints),
        errors_before_(diagnostics.error_count()),
        layered_(*scenario_, benchmark, diagnostics) {}

  std::optional<grid::Grid> Run() {
    if (!layered_.is_readable() || !Configure()) return std::nullopt;
    MakeAxes();
    CheckAxisNames({});
    const bool has_axes = !FailedBut(UnitErrors()) && layered_.is_complete();
    if (!has_axes || !MakeHead() || !MakeBlocks() || HasUnreadSkip()) {
      // There is no grid, but each setting can still be checked.
      for (const auto& configuration : configurations_) {
        configuration->CheckSettings();
        checks::ReadRequirements(*configuration, plan::kLeastRepeats);
      }
      return std::nullopt;
    }
    AddSettings();
    CheckScenes();
    if (Failed() || is_broken_) return std::nullopt;
    return std::move(grid_);
  }

 private:
  bool Failed() const { return FailedBut(0); }
  bool FailedBut(int errors) const { return diagnostics_.error_count() > errors_before_ + errors; }

  /// The number of errors of units in settings.
  int UnitErrors() const {
    int errors = 0;
    for (const auto& configuration : configurations_) errors += configuration->unit_errors();
    return errors;
  }

  bool TooMany(double count, double most, std::string_view what) {
    diagnostics_.Report(
        scenario::kTooManyRuns, benchmark_.benchmark->name.span,
        fmt::format("this benchmark has {:.6g} {}", count, what),
        fmt::format("the limit is {:g}; skip some by `skip`, or split the benchmark", most));
    return false;
  }

  bool Configure() {
    double count = 1;
    for (const scenario::CaseAxis& axis : layered_.case_axes()) {
      case_extents_.push_back(axis.names.size());
      count *= static_cast<double>(axis.names.size());
    }
    if (count > kMostCases) return TooMany(count, kMostCases, "choices of cases");
    configure::Point chosen(case_extents_.size(), 0);
    do {
      configurations_.push_back(std::make_shared<configure::Configuration>(
          *scenario_, layered_.Lay(chosen), diagnostics_));
    } while (configure::Advance(chosen, case_extents_));
    return true;
  }

  /// If true, skipped points cannot be told from others.
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
      axes_.push_back(std::move(axis));
    }
    for (const auto& configuration : configurations_)
      for (const configure::SweepAxis& sweep : configuration->axes()) Merge(sweep);
    std::ranges::stable_sort(axes_, {}, &GridAxis::order);
    for (GridAxis& axis : axes_)
      if (axis.sweep != nullptr) FillValues(axis);
  }

  void Merge(const configure::SweepAxis& sweep) {
    for (GridAxis& axis : axes_) {
      if (axis.axis.name != sweep.name) continue;
      if (axis.sweep == nullptr) {
        diagnostics_.Report(scenario::kAxisTwice, sweep.span,
                            fmt::format("there are already cases called '{}'", sweep.name),
                            fmt::format("name the axis: sweep(…) as {}_2", sweep.name));
      } else {
        axis.order = std::min(axis.order, sweep.order);
        if (axis.axis.title.empty()) axis.axis.title = sweep.title;
        if (axis.axis.sampled != sweep.sampled)
          diagnostics_.Report(scenario::kMisplacedSweep, sweep.span,
                              fmt::format("'{}' has other points in another case", sweep.name),
                              "sample in one place, outside the cases");
      }
      return;
    }
    GridAxis axis;
    axis.axis.name = sweep.name;
    axis.axis.parameter = sweep.parameter;
    axis.axis.unit = sweep.unit;
    axis.axis.title = sweep.title;
    axis.axis.sampled = sweep.sampled;
    axis.order = sweep.order;
    axis.sweep = &sweep;
    axes_.push_back(std::move(axis));
  }

  /// An axis is a variable of the results, so it cannot share the name of another variable.
  void CheckAxisNames(const std::vector<const schema::ErrorInfo*>& errors) {
    for (const GridAxis& axis : axes_) {
      const std::string& name = axis.axis.name;
      const auto clash = schema::FindNameClash(name, errors);
      if (!clash) continue;
      const bool is_cases = axis.sweep == nullptr;
      diagnostics_.Report(
          scenario::kReservedName,
          is_cases ? layered_.case_axes()[axis.case_axis].span : axis.sweep->span,
          fmt::format("an axis cannot be called '{}', which is the name of {}", name, *clash),
          is_cases ? fmt::format("give the cases another name: cases {}_case {{ … }}", name)
                   : fmt::format("give the axis another name: sweep(…) as {}_value", name));
    }
    std::set<std::string> taken;
    for (const GridAxis& axis : axes_)
      if (!axis.axis.sampled.empty()) taken.insert(axis.axis.name);
    for (const GridAxis& axis : axes_)
      for (const plan::Coordinates& of : axis.axis.sampled)
        if (!taken.insert(of.name).second)
          diagnostics_.Report(
              scenario::kReservedName, axis.sweep->span,
              fmt::format("'{}' would be the name of two arrays of /sampled in the results",
                          of.name),
              "give the axis, or the let, another name: zip(…) as design");
  }

  /// Fills the axis with every value that it has in some case; in a case that does not sweep it,
  /// with the value set there.
  void FillValues(GridAxis& axis) {
    for (const auto& configuration : configurations_) {
      std::vector<plan::Coordinate> here;
      const auto swept =
          std::ranges::find(configuration->axes(), axis.axis.name, &configure::SweepAxis::name);
      if (swept != configuration->axes().end()) {
        here = swept->values;
      } else {
        const auto value = configuration->ConstantFor(*axis.sweep);
        here.push_back(value ? configure::CoordinateOf(*value) : std::string(kNoValue));
      }
      axis.values.push_back(std::move(here));
    }
    bool text = false;
    for (const auto& here : axis.values)
      for (const plan::Coordinate& value : here) text = text || value.index() == 1;
    for (auto& here : axis.values) {
      for (plan::Coordinate& value : here) {
        if (text && value.index() == 0) value = schema::FormatReal(std::get<double>(value));
        if (axis.index.try_emplace(value, axis.axis.values.size()).second)
          axis.axis.values.push_back(value);
      }
    }
    if (!axis.axis.sampled.empty() && axis.axis.sampled[0].values.size() != axis.axis.values.size())
      diagnostics_.Report(scenario::kMisplacedSweep, axis.sweep->span,
                          fmt::format("'{}' is not used in every case", axis.axis.name),
                          "use one of its values in each case, or write a benchmark for each");
  }

  /// Makes axes and repeats.
  bool MakeHead() {
    for (const GridAxis& axis : axes_) grid_.head.axes.push_back(axis.axis);
    for (std::size_t i = 0; i < layered_.case_axes().size(); ++i)
      for (std::size_t a = 0; a < axes_.size(); ++a)
        if (axes_[a].case_axis == i) grid_.case_axes.push_back(a);
    const double points = grid::CountOf(grid_.extents());
    return FindRepeats() && FindBudget() && FindRequirements() && FindSearch() && FindRace() &&
           ObeysClock() && (points <= kMostPoints || TooMany(points, kMostPoints, "points"));
  }

  /// The value of a parameter that all points have in common; nullopt after an error.
  std::optional<schema::Value> CommonValue(schema::WorldParameter parameter,
                                           const char* why_not_swept) {
    const scenario::ParameterKey key("", parameter.get());
    const schema::Parameter* row = key.second;
    std::optional<schema::Value> common;
    for (const auto& configuration : configurations_) {
      configure::Configuration& here = *configuration;
      const text::Span span = here.SpanOf({"", row}, benchmark_.benchmark->name.span);
      if (!configure::Dependencies({&key, 1}, here.layers(), here.axes(), here.evaluator())[0]
               .empty()) {
        const text::Span whole = here.layers().settings.at({"", row}).node->values[0]->span;
        diagnostics_.Report(scenario::kMisplacedSweep, whole,
                            fmt::format("'{}' cannot be swept", row->name), why_not_swept);
        return std::nullopt;
      }
      auto setting = here.evaluator().EvaluateParameter({"", row});
      if (setting) setting = evaluate::Convert(*setting, *row, span, {}, {}, diagnostics_);
      if (!setting) return std::nullopt;
      if (common && *common != *setting) {
        diagnostics_.Report(scenario::kWrongPlace, span,
                            fmt::format("'{}' must be the same in every case", row->name),
                            "set it outside the cases");
        return std::nullopt;
      }
      common = std::move(setting);
    }
    return common;
  }

  bool FindRepeats() {
    const auto value =
        CommonValue("repeats", "every point has the same number: they make the axis `rep`");
    if (!value) return false;
    grid_.head.repeats = std::get<schema::Number>(*value).AsCount();
    if (grid_.head.repeats <= kMostListed) return true;
    diagnostics_.Report(
        scenario::kTooManyRuns,
        configurations_[0]->SpanOf({"", schema::WorldParameter("repeats").get()},
                                   benchmark_.benchmark->name.span),
        fmt::format("a point has {} repeats, but the limit is {}", grid_.head.repeats, kMostListed),
        "use fewer repeats, or sweep the seed");
    return false;
  }

  /// One file has one unit of time. Nothing is judged by times if none are measured.
  bool ObeysClock() {
    const auto clock =
        CommonValue("clock",
                    "a results file has one clock: run it twice, with --set clock=time and "
                    "--set clock=instructions");
    if (!clock) return false;
    if (*clock != schema::Value(schema::Word{"instructions"})) return true;
    const auto is_time = [](const plan::Figure& figure) { return figure.Unit() == "ns"; };
    // The memory of the process is that of Valgrind, too.
    const auto is_unknown = [&](const plan::Figure& figure) {
      return is_time(figure) || figure.name == "peak_rss";
    };
    if (race_ || (search_ && is_unknown(search_->what.figure))) {
      const bool needs_times = race_ || is_time(search_->what.figure);
      diagnostics_.Report(
          scenario::kContradiction, race_ ? race_->span : search_->span,
          fmt::format("this {} needs {}, and `clock instructions` measures none",
                      race_ ? "race" : "search", needs_times ? "times" : "the peak memory"),
          "use `clock time`");
      return false;
    }
    const auto drop = [&](const text::Span& span, const std::string& what, const char* unmeasured) {
      diagnostics_.Report(
          scenario::kNoEffect, span,
          fmt::format("{} is not checked: `clock instructions` measures no {}", what, unmeasured),
          "remove one of them, or use `clock time`");
    };
    if (grid_.head.budget_s)
      drop(configurations_[0]->SpanOf({"", schema::WorldParameter("budget").get()},
                                      benchmark_.benchmark->name.span),
           "'budget'", "times");
    grid_.head.budget_s = grid_.head.frame_s = std::nullopt;
    std::erase_if(requirements_, [&](const checks::WrittenRequirement& one) {
      if (!is_unknown(one.what.figure)) return false;
      drop(one.span, fmt::format("'{}'", one.what.text),
           is_time(one.what.figure) ? "times" : "peak memory");
      return true;
    });
    std::erase_if(grid_.head.requirements,
                  [&](const plan::Requirement& one) { return is_unknown(one.figure); });
    return true;
  }

  bool FindBudget() {
    const auto budget = CommonValue("budget",
                                    "one budget holds for all points; for a budget of all steps of "
                                    "a frame, set `frame 1/60 s`"),
               frame = CommonValue("frame", "one budget, and one frame, holds for all points");
    if (!budget || !frame) return false;
    if (const auto* number = std::get_if<schema::Number>(&*budget))
      grid_.head.budget_s = number->AsReal();
    const auto* number = std::get_if<schema::Number>(&*frame);
    if (number == nullptr) return true;
    grid_.head.frame_s = number->AsReal();
    if (!grid_.head.budget_s)
      diagnostics_.Report(scenario::kNoEffect,
                          configurations_[0]->SpanOf({"", schema::WorldParameter("frame").get()},
                                                     benchmark_.benchmark->name.span),
                          "'frame' has no effect without a budget", "set budget, or remove it");
    return true;
  }

  bool FindRequirements() {
    bool is_first = true;
    for (const auto& configuration : configurations_) {
      auto found = checks::ReadRequirements(*configuration, grid_.head.repeats);
      if (!found) return false;
      for (std::size_t i = 0; i < found->size() && !is_first; ++i) {
        if ((*found)[i].what.IsSame(requirements_[i].what)) continue;
        diagnostics_.Report(scenario::kWrongPlace, (*found)[i].span,
                            "the limit of a requirement must be the same in every case",
                            "write a number, or set its names outside the cases");
        return false;
      }
      if (is_first) requirements_ = std::move(*found);
      is_first = false;
    }
    std::vector<plan::Requirement>& all = grid_.head.requirements;
    for (const checks::WrittenRequirement& one : requirements_)
      if (std::ranges::none_of(all, [&](const auto& other) { return one.what.IsSame(other); }))
        all.push_back(one.what);
    return true;
  }

  /// Reads the condition of `find( )`, if there is one.
  bool FindSearch() {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const bool is_searched = std::ranges::any_of(configurations_, [&](const auto& here) {
        const configure::SweepAxis* sweep = SweepOf(axes_[i], *here);
        return sweep != nullptr && evaluate::IsFind(*sweep->call);
      });
      if (is_searched && !FindSearch(axes_[i], grid_.head.axes[i])) return false;
    }
    return true;
  }

  static const configure::SweepAxis* SweepOf(const GridAxis& axis,
                                             const configure::Configuration& configuration) {
    const auto found =
        std::ranges::find(configuration.axes(), axis.axis.name, &configure::SweepAxis::name);
    return found == configuration.axes().end() ? nullptr : &*found;
  }

  bool FindSearch(const GridAxis& axis, plan::Axis& searched) {
    const auto fail = [&](std::string message, std::string help) {
      diagnostics_.Report(scenario::kMisplacedSweep, axis.sweep->span, std::move(message),
                          std::move(help));
      return false;
    };
    if (search_)
      return fail("a benchmark has one find()", "write a benchmark for each, or sweep the others");
    for (const auto& configuration : configurations_) {
      const configure::SweepAxis* sweep = SweepOf(axis, *configuration);
      if (sweep == nullptr || !evaluate::IsFind(*sweep->call) ||
          sweep->values.size() != axis.axis.values.size())
        return fail(fmt::format("'{}' has other values in another case", axis.axis.name),
                    "write one find() outside the cases, or a benchmark for each");
      auto until =
          checks::ReadUntil(*configuration, *sweep->call->until, sweep->scope, grid_.head.repeats);
      if (!until) return false;
      if (search_ && !until->what.IsSame(search_->what))
        return fail("the condition of find() must be the same in every case",
                    "set the names in it outside the cases");
      searched.search = {until->what, sweep->is_log};
      search_ = std::move(until);
    }
    return true;
  }

  /// Reads the races of all axes, which are one.
  bool FindRace() {
    for (std::size_t i = 0; i < axes_.size(); ++i)
      for (const auto& configuration : configurations_) {
        const configure::SweepAxis* sweep = SweepOf(axes_[i], *configuration);
        if (sweep == nullptr || !evaluate::IsRace(*sweep->call)) continue;
        auto race = checks::ReadRace(*configuration, *sweep->call, sweep->scope);
        if (!race) return false;
        const auto fail = [&](std::string message, std::string help) {
          diagnostics_.Report(scenario::kMisplacedSweep, race->span, std::move(message),
                              std::move(help));
          return false;
        };
        if (search_)
          return fail("a benchmark has find() or race(), and not both",
                      "write a benchmark for each, or sweep one of them");
        if (race_ && race->what != race_->what)
          return fail("the races of a benchmark are one: of all combinations of their values",
                      "state the same figure and tolerance in each");
        grid_.head.axes[i].race = race->what;
        race_ = std::move(race);
      }
    if (!race_) return true;
    std::size_t racers = 1;
    for (const std::size_t axis : grid_.head.RaceAxes())
      racers *= grid_.head.axes[axis].values.size();
    const std::uint64_t least = plan::LeastRaceRepeats(racers);
    if (grid_.head.repeats >= least) return true;
    diagnostics_.Report(
        scenario::kBadArguments, race_->span,
        fmt::format("a race of {} drops nobody before repeat {}, and `repeats` is {}", racers,
                    least, grid_.head.repeats),
        fmt::format("write the most that it may take, such as repeats {}", 5 * least));
    return false;
  }

  /// Reports axes that have the name of an array that is in one group with them.
  void CheckNamesBeside(std::string_view what, std::span<const std::string_view> names) {
    for (const GridAxis& axis : axes_)
      if (std::ranges::find(names, axis.axis.name) != names.end())
        diagnostics_.Report(
            scenario::kReservedName,
            axis.sweep == nullptr ? layered_.case_axes()[axis.case_axis].span : axis.sweep->span,
            fmt::format("an axis beside {} cannot be called '{}', which is a name of theirs in the "
                        "results",
                        what, axis.axis.name),
            fmt::format("give it another name, such as {}_of", axis.axis.name));
  }

  /// Reports requirements, and conditions of `find( )`, on figures that no run has.
  void CheckRequirements() {
    // The arrays of /requirements, /boundary and /race (runtime/results/layout.cc).
    constexpr std::string_view kOfRequirements[] = {"requirement", "figure", "comparison", "limit",
                                                    "answer",      "value",  "low",        "high"};
    constexpr std::string_view kOfBoundaries[] = {"value",   "low",     "high",
                                                  "outcome", "changes", "probes"};
    constexpr std::string_view kOfRaces[] = {"outcome", "repeats", "against",
                                             "ratio",   "low",     "high"};
    if (!requirements_.empty()) CheckNamesBeside("requirements", kOfRequirements);
    if (search_) {
      CheckNamesBeside("boundaries", kOfBoundaries);
      requirements_.push_back(*search_);
    }
    if (race_) {
      CheckNamesBeside("races", kOfRaces);
      requirements_.push_back({{.text = {}, .figure = race_->what.by}, race_->span, race_->figure});
    }
    if (requirements_.empty()) return;
    std::vector<bool> is_recorded(requirements_.size(), false);
    grid::Survey(grid_).Look(
        std::numeric_limits<std::uint64_t>::max(), {}, [](bool) {},
        [&](const grid::Sample&, const plan::Scene& scene) {
          for (std::size_t i = 0; i < requirements_.size(); ++i)
            if (checks::HasFigure(scene, requirements_[i].what.figure)) is_recorded[i] = true;
        });
    for (std::size_t i = 0; i < requirements_.size(); ++i)
      if (!is_recorded[i])
        checks::ReportNotRecorded(requirements_[i], benchmark_.benchmark->name.text, diagnostics_);
  }

  /// Makes the blocks without settings: the points with a run. False if there are too many.
  bool MakeBlocks() {
    double runs = 0;
    for (std::size_t i = 0; i < configurations_.size(); ++i) {
      makers_.emplace_back(scenario_, configurations_[i], grid_.head.axes, PlacesOf(i));
      grid_.blocks.push_back(makers_.back().MakeConditions());
      const std::uint64_t left = grid::RemainingBy(grid_.blocks.back(), {}).counts[0];
      grid_.point_count += left;
      runs += static_cast<double>(left) * static_cast<double>(grid_.head.repeats);
    }
    if ((search_ || race_) && runs > kMostListed) {
      diagnostics_.Report(scenario::kTooManyRuns, search_ ? search_->span : race_->span,
                          fmt::format("this {} is among {:.6g} runs, of which it needs few",
                                      search_ ? "search" : "race", runs),
                          fmt::format("the limit is {}: {}, or split the benchmark", kMostListed,
                                      search_ ? "raise the tolerance" : "write fewer repeats"));
      return false;
    }
    return runs <= configure::kMostRuns || TooMany(runs, configure::kMostRuns, "runs");
  }

  /// The values of each axis in a configuration, as indices.
  std::vector<grid::Point> PlacesOf(std::size_t configuration) const {
    std::vector<grid::Point> places;
    std::size_t rest = configuration;
    grid::Point chosen(case_extents_.size());
    for (std::size_t i = case_extents_.size(); i-- > 0;) {
      chosen[i] = rest % case_extents_[i];
      rest /= case_extents_[i];
    }
    for (const GridAxis& axis : axes_) {
      if (axis.sweep == nullptr) {
        places.push_back({chosen[axis.case_axis]});
        continue;
      }
      places.emplace_back();
      for (const plan::Coordinate& value : axis.values[configuration])
        places.back().push_back(axis.index.at(value));
    }
    return places;
  }

  void AddSettings() {
    for (std::size_t i = 0; i < makers_.size(); ++i)
      is_broken_ = !makers_[i].AddSettings(grid_.blocks[i]) || is_broken_;
  }

  void CheckScenes() {
    const auto choose = [this](std::size_t block, const grid::Point& local) -> auto& {
      makers_[block].Choose(local);
      return makers_[block].configuration();
    };
    GridChecks checks(grid_, choose, benchmark_.benchmark->name.span, diagnostics_);
    checks.Check();
    if (Failed() || is_broken_) return;
    CheckAxisNames(ErrorsOfAllRuns());
    CheckRequirements();
    if (Failed()) return;
    if (grid_.point_count == 0) {
      diagnostics_.Report(scenario::kNoRuns, benchmark_.benchmark->name.span,
                          fmt::format("'{}' has no runs left", benchmark_.benchmark->name.text),
                          "its `skip` skips every point");
      return;
    }
    checks.FindFaults(find_fault_);
    if (lints_) checks.Lint();
  }

  std::vector<const schema::ErrorInfo*> ErrorsOfAllRuns() const {
    std::vector<const schema::ErrorInfo*> errors;
    grid::Survey(grid_).Look(
        std::numeric_limits<std::uint64_t>::max(), {}, [](bool) {},
        [&](const grid::Sample&, const plan::Scene& scene) {
          for (const schema::ErrorInfo* error : analysis::ErrorsOf(scene))
            if (std::ranges::find(errors, error) == errors.end()) errors.push_back(error);
        });
    return errors;
  }

  std::shared_ptr<const scenario::Scenario> scenario_;
  const scenario::BenchmarkRef& benchmark_;
  const analysis::FindSceneFault& find_fault_;
  dsl::Diagnostics& diagnostics_;
  bool lints_;
  int errors_before_;
  scenario::LayeredBenchmark layered_;
  std::vector<std::size_t> case_extents_;
  std::vector<std::shared_ptr<configure::Configuration>> configurations_;
  std::deque<BlockMaker> makers_;  ///< for each configuration
  std::vector<GridAxis> axes_;
  std::vector<checks::WrittenRequirement> requirements_;
  std::optional<checks::WrittenRequirement> search_;
  std::optional<checks::WrittenRace> race_;
  grid::Grid grid_;
  /// A point has an error, which another benchmark may already have reported.
  bool is_broken_ = false;
};

}  // namespace

std::optional<grid::Grid> Expand(std::shared_ptr<const scenario::Scenario> scenario,
                                 const scenario::BenchmarkRef& benchmark,
                                 const analysis::FindSceneFault& find_fault,
                                 dsl::Diagnostics& diagnostics, bool lints) {
  return Expander(std::move(scenario), benchmark, find_fault, diagnostics, lints).Run();
}

void GridChecks::Replay(const dsl::Diagnostics& found) {
  for (const dsl::Diagnostic& one : found.all())
    diagnostics_.Report(*one.kind, one.span, one.message, one.help, one.notes);
}

void GridChecks::Check() {
  std::optional<dsl::Diagnostics> found;
  std::optional<checks::SceneChecks> checks;
  survey_.Look(
      std::numeric_limits<std::uint64_t>::max(), {},
      [&](bool) { checks.emplace(benchmark_, found.emplace()); },
      [&](const grid::Sample& sample, const plan::Scene& scene) {
        configure::Configuration& configuration = choose_(sample.block, sample.local);
        plan::Scene laid = scene;
        if (analysis::HasConfigurations(scene))
          checks->PassConfigurations(configuration, laid);
        else if (analysis::TraceOf(scene))
          checks->PassTraced(configuration, laid);
        else
          checks->Pass(configuration, scene);
      });
  Replay(*found);
}

/// The axes that determine the placement, so that no scene is placed twice. A closed form may
/// depend on every axis.
grid::AxisSet GridChecks::AxesOfPlacement() const {
  grid::AxisSet axes;
  constexpr schema::WorldParameter kClosedForm = "accuracy.closed_form", kSeed = "seed",
                                   kSide = "world.side", kWalls = "world.walls",
                                   kAcceleration = "acceleration", kTrace = "trace";
  bool has_closed_form = false;
  for (const grid::Block& block : grid_.blocks) {
    has_closed_form = has_closed_form || block.base.world.WordOr("accuracy.closed_form") != "none";
    for (const grid::VaryingSetting& setting : block.varying) {
      const schema::Parameter* parameter = setting.parameter;
      has_closed_form = has_closed_form || parameter == kClosedForm.get();
      if (parameter->grouped || parameter == kSeed.get() || parameter == kSide.get() ||
          parameter == kWalls.get() || parameter == kAcceleration.get() ||
          parameter == kTrace.get())
        axes = grid::Union(axes, setting.by.axes());
    }
  }
  return has_closed_form ? grid::AllAxes(grid_.head.axes.size()) : axes;
}

void GridChecks::FindFaults(const analysis::FindSceneFault& find) {
  std::optional<dsl::Diagnostics> found;
  std::optional<checks::SceneFaults> faults;
  survey_.Look(
      kMostPlaced, AxesOfPlacement(),
      [&](bool is_whole) {
        faults.emplace(benchmark_, find, found.emplace(),
                       is_whole ? checks::SceneFaults::kMostObjects : kMostObjectsOfMany);
      },
      [&](const grid::Sample& sample, const plan::Scene& scene) {
        if (!analysis::TraceOf(scene))
          faults->Add(choose_(sample.block, sample.local), scene,
                      sample.points * grid_.head.repeats);
      });
  faults->Report(grid_.run_count());
  Replay(*found);
}

void GridChecks::Lint() {
  std::optional<lints::LintFindings> findings;
  std::optional<checks::IdleSettings> idle;
  std::uint64_t looked_at = 0;
  survey_.Look(
      kMostLinted, {},
      [&](bool) {
        findings.emplace(benchmark_, diagnostics_);
        idle.emplace(benchmark_, diagnostics_);
        looked_at = 0;
      },
      [&](const grid::Sample& sample, const plan::Scene& scene) {
        const std::uint64_t runs = sample.points * grid_.head.repeats;
        looked_at += runs;
        if (grid::IsLaid(scene)) return;
        configure::Configuration& configuration = choose_(sample.block, sample.local);
        findings->Add(configuration, scene, runs);
        idle->Add(configuration, scene);
      });
  idle->Report();
  findings->Report(looked_at, grid_.run_count());
}

}  // namespace cdb::compiler
