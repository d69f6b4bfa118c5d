#include "runtime/suite/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "compiler/schema/catalogue.h"
#include "runtime/document/time_steps.h"
#include "runtime/machine/noise.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/figures.h"
#include "runtime/statistics/points.h"
#include "runtime/terminal/table.h"

namespace cdb::suite {
namespace {

using Cell = store::ResultFile::Cell;

/// Fraction of the cycles that a step counted as slow exceeds.
constexpr double kSlowStep = 0.99;

class SceneCollector {
 public:
  SceneCollector(const StandardScene& scene, const store::ResultFile& file)
      : scene_(scene),
        file_(file),
        times_(file),
        steps_(file),
        points_(statistics::MeasuredPoints(file, false)) {
    if (!file.Has("duration"))
      throw files::StoreError(fmt::format(
          "the results of {} have no times, so they are not results of the suite", scene.Id()));
  }

  SceneFigures All() {
    SceneFigures all = {&scene_, file_.title(), 1, {}};
    for (const auto& [name, points] : Configurations()) {
      all.seeds = points.size();
      all.configurations.push_back(Collect(name, points));
    }
    AddSpeedups(all.configurations);
    return all;
  }

 private:
  using Named = std::pair<std::string, std::vector<statistics::Point>>;

  /// Points by the names of their configurations, in grid order.
  std::vector<Named> Configurations() const {
    std::vector<Named> all;
    for (const Cell& cell : statistics::AllCells(file_)) {
      if (cell.rep != 0) continue;
      std::vector<std::string> values;
      for (std::size_t i = 0; i < cell.at.size(); ++i)
        if (file_.axes()[i].parameter != "seed")
          values.push_back(terminal::CoordinateText(file_.axes()[i], cell.at[i]));
      std::string name = values.empty() ? "default" : fmt::format("{}", fmt::join(values, ", "));
      const auto there = std::ranges::find(all, name, &Named::first);
      if (there == all.end())
        all.push_back({std::move(name), {cell.at}});
      else
        there->second.push_back(cell.at);
    }
    return all;
  }

  bool IsBulletsOwn(const statistics::Point& at) const {
    const auto axis = statistics::DetectorAxis(file_);
    if (!axis) return true;
    const std::string name = terminal::CoordinateText(file_.axes()[*axis], at[*axis]);
    return std::ranges::any_of(schema::Detectors(), [&](const schema::DetectorInfo& info) {
      return info.name == name && info.source == "Bullet";
    });
  }

  const statistics::MeasuredPoint* FindPoint(const statistics::Point& at) const {
    const auto found = std::ranges::find(points_, at, &statistics::MeasuredPoint::at);
    return found == points_.end() ? nullptr : &*found;
  }

  ConfigurationFigures Collect(const std::string& name,
                               const std::vector<statistics::Point>& points) {
    ConfigurationFigures of;
    of.name = name;
    of.is_bullets_own = IsBulletsOwn(points[0]);
    std::vector<statistics::Estimate> times;
    for (const statistics::Point& at : points) {
      AddRuns(at, of);
      const statistics::MeasuredPoint* point = FindPoint(at);
      if (point == nullptr) continue;
      AddFigures(*point, of);
      times.push_back(TimeOf(*point));
    }
    if (!times.empty() && times.size() == points.size())
      of.ms_per_s = statistics::GeometricMeanOf(times);
    AddFault(of);
    return of;
  }

  statistics::Estimate TimeOf(const statistics::MeasuredPoint& point) {
    return statistics::Scaled(times_.Of(point, measure::Phase::kStep).mean,
                              1e-6 / steps_.Of(point.cells[0]));
  }

  /// The first fault is kept.
  static void SetFault(ConfigurationFigures& of, std::string fault) {
    if (of.fault.empty()) of.fault = std::move(fault);
  }

  static void SetDisturbed(ConfigurationFigures& of, std::string fault) {
    of.fault = std::move(fault);
    of.is_disturbed = true;
  }

  /// Adds the verdicts of all repeats.
  void AddRuns(const statistics::Point& at, ConfigurationFigures& of) const {
    measure::Judgement worst;
    for (std::uint64_t rep = 0; rep < file_.repeats(); ++rep) {
      const Cell cell{at, rep};
      ++of.repeats;
      const store::Status status = file_.ReadStatus(cell);
      const measure::Judgement judgement = file_.ReadJudgement(cell);
      if (judgement.verdict > worst.verdict) worst = judgement;
      if (status == store::Status::kDone && file_.Has("noise"))
        of.noisy +=
            static_cast<machine::Noise>(file_.ReadReal("noise", cell)) == machine::Noise::kNoisy;
      if (status == store::Status::kDone && judgement.verdict == measure::Verdict::kUnknown)
        SetFault(of, "no verdict");
      if (status != store::Status::kDone) SetFault(of, std::string(store::StatusName(status)));
    }
    if (worst.verdict > of.verdict) of.verdict = worst.verdict;
    if (worst.verdict > scene_.worst_verdict)
      SetFault(of, worst.first_bad_cycle < 0
                       ? std::string(measure::VerdictName(worst.verdict))
                       : fmt::format("{} from cycle {}", measure::VerdictName(worst.verdict),
                                     worst.first_bad_cycle));
  }

  void AddFigures(const statistics::MeasuredPoint& point, ConfigurationFigures& of) {
    of.time_step_s = steps_.Of(point.cells[0]);
    const statistics::PhaseTimes& steps = times_.Of(point, measure::Phase::kStep);
    of.step_ns = std::fmax(of.step_ns, steps.mean.value);
    std::vector<double> sorted = steps.cycles;
    std::ranges::sort(sorted);
    of.slow_step_ns = std::fmax(of.slow_step_ns, statistics::Percentile(sorted, kSlowStep));
    for (const Cell& cell : point.cells)
      if (file_.Has("peak_rss"))
        of.memory_bytes = std::fmax(of.memory_bytes, file_.ReadReal("peak_rss", cell));
    const std::string dataset = "accuracy/" + std::string(scene_.error);
    for (const Cell& cell : point.cells) {
      const double error = file_.Has(dataset) ? file_.ReadReal(dataset, cell) : statistics::kNone;
      if (std::isnan(error)) SetFault(of, fmt::format("its error ({}) is not known", scene_.error));
      of.error = std::fmax(of.error, error);
    }
    if (!point.unlike.empty())
      SetFault(of, fmt::format("ran without {}, which others kept", fmt::join(point.unlike, ", ")));
  }

  /// Disturbances are checked last: other faults are not due to the machine.
  void AddFault(ConfigurationFigures& of) const {
    if (!of.fault.empty()) return;
    if (of.error > scene_.bound)
      of.fault = scene_.bound == 0
                     ? fmt::format("{} {}", scene_.error, terminal::ShortNumber(of.error))
                     : fmt::format("{} error {} over {}", scene_.error,
                                   terminal::ShortNumber(of.error), scene_.bound);
    else if (!std::isfinite(of.ms_per_s.value) || of.ms_per_s.value <= 0)
      of.fault = "no time";
    else if (of.IsNoisy())
      SetDisturbed(of, fmt::format("noisy in {} of {} runs", of.noisy, of.repeats));
  }

  /// A wrong baseline still has the times of Bullet's defaults. A disturbed baseline, or one with
  /// void timings, gives no speedups.
  void AddSpeedups(std::vector<ConfigurationFigures>& all) const {
    const ConfigurationFigures& baseline = all[0];
    const statistics::MeasuredPoint* point = FindPoint(statistics::Point(file_.axes().size(), 0));
    const bool is_timed =
        std::isfinite(baseline.ms_per_s.value) && point != nullptr && point->IsSound();
    const std::string untimed = fmt::format("the baseline {} has no valid time", baseline.name);
    for (ConfigurationFigures& of : all) {
      if (!is_timed)
        SetFault(of, untimed);
      else if (baseline.IsNoisy() && of.fault.empty())
        SetDisturbed(of, fmt::format("the baseline {} is noisy", baseline.name));
      if (!is_timed || !std::isfinite(of.ms_per_s.value)) continue;
      of.speedup = statistics::RatioOf(baseline.ms_per_s, of.ms_per_s);
      of.speedup_interval = times_.IntervalOf(of.speedup);
    }
  }

  const StandardScene& scene_;
  const store::ResultFile& file_;
  statistics::CycleTimes times_;
  const document::TimeSteps steps_;
  const std::vector<statistics::MeasuredPoint> points_;
};

/// `rubble: not run`, for each scene of the kind without results.
std::vector<std::string> FaultsOfMissing(const Kind& kind,
                                         const std::vector<const SceneFigures*>& scenes) {
  std::vector<std::string> faults;
  for (const StandardScene& scene : StandardScenes())
    if (scene.kind == kind.name && std::ranges::none_of(scenes, [&](const SceneFigures* of) {
          return of->scene->name == scene.name;
        }))
      faults.push_back(fmt::format("{}: not run", scene.name));
  return faults;
}

/// The score of a configuration over the scenes of a kind.
KindScore ScoreOf(const std::string& name, const std::vector<const SceneFigures*>& scenes,
                  const std::vector<std::string>& faults) {
  KindScore of;
  of.name = name;
  of.faults = faults;
  std::vector<statistics::Estimate> speedups;
  for (const SceneFigures* scene : scenes) {
    const ConfigurationFigures* found = scene->Find(name);
    if (found == nullptr) {
      of.faults.push_back(fmt::format("{}: not there", scene->scene->name));
      continue;
    }
    of.memory_bytes = std::fmax(of.memory_bytes, found->memory_bytes);
    if (found->HasScore())
      speedups.push_back(found->speedup);
    else
      of.faults.push_back(fmt::format("{}: {}", scene->scene->name, found->fault));
  }
  if (!of.faults.empty()) return of;
  for (const statistics::Estimate& speedup : speedups)
    if (speedup.drawn.size() != speedups[0].drawn.size())
      throw files::StoreError(
          fmt::format("the scenes of {} have different numbers of repeats: their results are not "
                      "of one run of the suite",
                      scenes[0]->scene->kind));
  const statistics::Estimate score = statistics::GeometricMeanOf(speedups);
  of.score = score.value;
  of.interval = statistics::Bootstrap(score.things).IntervalOf(score);
  return of;
}

}  // namespace

bool ConfigurationFigures::Fits(double period_s) const {
  const double steps = std::fmax(1, std::round(period_s / time_step_s));
  return steps * slow_step_ns * 1e-9 <= period_s;
}

const ConfigurationFigures* SceneFigures::Find(const std::string& name) const {
  const auto found = std::ranges::find(configurations, name, &ConfigurationFigures::name);
  return found == configurations.end() ? nullptr : &*found;
}

bool SceneFigures::IsOnFront(const ConfigurationFigures& of) const {
  return of.HasScore() &&
         std::ranges::none_of(configurations, [&](const ConfigurationFigures& other) {
           const double time = other.ms_per_s.value - of.ms_per_s.value,
                        error = other.error - of.error;
           return other.HasScore() && time <= 0 && error <= 0 && (time < 0 || error < 0);
         });
}

SceneFigures CollectScene(const StandardScene& scene, const store::ResultFile& file) {
  return SceneCollector(scene, file).All();
}

std::vector<KindFigures> ScoreKinds(const std::vector<SceneFigures>& scenes) {
  std::vector<KindFigures> all;
  for (const Kind& kind : Kinds()) {
    KindFigures of = {&kind, {}, {}, {}};
    std::vector<std::string> names;
    for (const SceneFigures& scene : scenes) {
      if (scene.scene->kind != kind.name) continue;
      of.scenes.push_back(&scene);
      for (const ConfigurationFigures& configuration : scene.configurations)
        if (std::ranges::find(names, configuration.name) == names.end())
          names.push_back(configuration.name);
    }
    if (of.scenes.empty()) continue;
    of.baseline = of.scenes[0]->configurations[0].name;
    const auto faults = FaultsOfMissing(kind, of.scenes);
    for (const std::string& name : names) of.scores.push_back(ScoreOf(name, of.scenes, faults));
    std::ranges::stable_sort(of.scores, {}, [](const KindScore& score) {
      return std::pair(std::isnan(score.score), std::isnan(score.score) ? 0.0 : -score.score);
    });
    all.push_back(std::move(of));
  }
  return all;
}

std::vector<const ConfigurationFigures*> Recommend(const SceneFigures& scene, double period_s,
                                                   bool only_bullets_own) {
  std::vector<const ConfigurationFigures*> fitting;
  for (const ConfigurationFigures& of : scene.configurations)
    if (of.HasScore() && of.Fits(period_s) && (!only_bullets_own || of.is_bullets_own))
      fitting.push_back(&of);
  if (fitting.empty()) return {};
  std::ranges::stable_sort(fitting, {}, [](const ConfigurationFigures* of) {
    return std::pair(of->error, of->ms_per_s.value);
  });
  const ConfigurationFigures& best = *fitting[0];
  std::erase_if(fitting, [&](const ConfigurationFigures* of) { return of->error > best.error; });
  const statistics::Bootstrap bootstrap(best.ms_per_s.things);
  const auto is_slower = [&](const ConfigurationFigures& of, const ConfigurationFigures& other) {
    // Without repeats there is no interval, and no tie.
    return !(bootstrap.IntervalOf(statistics::RatioOf(of.ms_per_s, other.ms_per_s)).low <= 1);
  };
  std::vector<const ConfigurationFigures*> recommended;
  for (const ConfigurationFigures* of : fitting)
    if (of == &best || std::ranges::none_of(fitting, [&](const ConfigurationFigures* other) {
          return of != other && is_slower(*of, *other);
        }))
      recommended.push_back(of);
  return recommended;
}

}  // namespace cdb::suite
