#include "runtime/figures/suite.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "compiler/schema/catalogue.h"
#include "runtime/protocol/machine/noise.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

constexpr SuiteKind kKinds[] = {
    {"games", "many objects in motion, at 240 steps a second"},
    {"granular", "grains and heaps: dense, lasting contacts"},
    {"robotics", "logistics and bin picking: stacks, parts and moving pushers"},
    {"haptics", "one probe among fixed bodies, a thousand steps a second"},
    {"planning", "movers among thousands of fixed obstacles: is there contact?"},
    {"extreme", "unequal sizes, a large world, a fast gas"},
    {"joints", "bodies held together by joints, in maximal and in reduced coordinates"},
    {"stiff", "settings of Bullet in place of detectors: contacts, joints, time steps"},
    {"soft", "settings of Bullet's worlds of soft bodies: iterations, time steps, springs"},
};

// One missed pair is one collision that does not happen. The other bounds are rounded values
// between the errors of settings that a viewer accepts and those of settings that visibly fail: a
// stack that slides by a fiftieth of a box, a ball that loses a tenth of its energy, a pendulum
// that gains or loses a twentieth, a rope that is off by a twentieth of its length. If hundreds of
// bodies move, it is a matter of chance whether a few overlap by a twentieth of their size: with
// another seed, the same work gets another verdict.
constexpr auto kPenetrating = protocol::Verdict::kPenetrating;
constexpr StandardScene kScenes[] = {
    {"games", "debris", "3000 pieces of debris in orbit", "pairs_missed", 0, kPenetrating},
    {"games", "rubble", "800 falling chunks of rubble", "pairs_missed", 0, kPenetrating},
    {"granular", "drum", "600 grains in a turning drum", "pairs_missed", 0, kPenetrating},
    {"granular", "heap", "a settled heap of 400 objects", "pairs_missed", 0, kPenetrating},
    {"robotics", "warehouse", "1000 stacked boxes and a vehicle", "pairs_missed", 0, kPenetrating},
    {"robotics", "bin", "a finger that pushes 300 parts", "pairs_missed", 0, kPenetrating},
    {"haptics", "probe", "a probe on 2000 fixed bumps, at 1 kHz", "pairs_missed", 0},
    {"planning", "clutter", "20 movers among 4000 obstacles", "pairs_missed", 0},
    {"extreme", "sizes", "2000 bodies of very different sizes", "pairs_missed", 0, kPenetrating},
    {"extreme", "large_world", "2000 bodies in a world of 25 km", "pairs_missed", 0, kPenetrating},
    {"extreme", "swarm", "a fast gas of 3000 balls", "pairs_missed", 0, kPenetrating},
    {"joints", "ragdolls", "eight ragdolls that fall on stairs", "pairs_missed", 0},
    {"joints", "gripper", "a gripper that lifts a box from a belt", "pairs_missed", 0},
    {"stiff", "stack", "a stack of five boxes that should remain standing", "position", 0.02},
    {"stiff", "bounce", "a ball that bounces without loss", "energy", 0.1},
    {"stiff", "pendulum", "a pendulum on a ball joint", "energy", 0.05},
    {"soft", "rope", "a rope that swings", "position", 0.05},
};

/// Fraction of the cycles that a step counted as slow exceeds.
constexpr double kSlowStep = 0.99;

class SceneCollector {
 public:
  SceneCollector(const StandardScene& scene, const Model& model)
      : scene_(scene), file_(model.file()), model_(model) {
    if (!model_.HasTimes())
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
  using Named = std::pair<std::string, std::vector<Point>>;

  /// The values by which the point's configuration is named.
  std::string NameOf(const Point& at) const {
    std::vector<std::string> values;
    bool is_first = true;
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (file_.axes()[i].parameter == "seed") continue;
      if (is_first || at[i] != 0)
        values.push_back(terminal::CoordinateText(file_.axes()[i], at[i]));
      is_first = false;
    }
    return values.empty() ? "default" : fmt::format("{}", fmt::join(values, " + "));
  }

  /// Points by the names of their configurations, in grid order, without those that `skip` left
  /// out.
  std::vector<Named> Configurations() const {
    std::vector<Named> all;
    for (const Point& at : AllPoints(file_)) {
      if (file_.ReadStatus({at, 0}) == results::Status::kSkipped) continue;
      std::string name = NameOf(at);
      const auto there = std::ranges::find(all, name, &Named::first);
      if (there == all.end())
        all.push_back({std::move(name), {at}});
      else
        there->second.push_back(at);
    }
    return all;
  }

  /// The value at the point on the axis of a parameter; empty if there is no such axis.
  std::string ValueOf(std::string_view parameter, const Point& at) const {
    const auto axis = std::ranges::find(file_.axes(), parameter, &plan::Axis::parameter);
    if (axis == file_.axes().end()) return {};
    return terminal::CoordinateText(*axis,
                                    at[static_cast<std::size_t>(axis - file_.axes().begin())]);
  }

  bool IsBulletsOwn(const Point& at) const {
    const std::string detector = ValueOf("detector", at), narrow = ValueOf("narrow_phase", at);
    const bool has_narrow = !narrow.empty() && narrow != "own" && narrow != "bullet";
    return !has_narrow &&
           (detector.empty() ||
            std::ranges::any_of(schema::Detectors(), [&](const schema::DetectorInfo& info) {
              return info.name == detector && info.source == "Bullet";
            }));
  }

  ConfigurationFigures Collect(const std::string& name, const std::vector<Point>& points) {
    ConfigurationFigures of;
    of.name = name;
    of.is_bullets_own = IsBulletsOwn(points[0]);
    std::vector<Estimate> times;
    for (const Point& at : points) {
      AddRuns(at, of);
      const MeasuredPoint* point = model_.Find(at);
      if (point == nullptr) continue;
      AddFigures(*point, of);
      times.push_back(model_.MsPerSecondOf(*point));
    }
    if (!times.empty() && times.size() == points.size()) of.ms_per_s = GeometricMeanOf(times);
    AddFault(of);
    return of;
  }

  /// The first fault is kept.
  static void SetFault(ConfigurationFigures& of, std::string fault) {
    if (of.fault.empty()) of.fault = std::move(fault);
  }

  static void SetDisturbed(ConfigurationFigures& of, std::string fault) {
    of.fault = std::move(fault);
    of.is_disturbed = true;
  }

  /// Adds the endings of all repeats.
  void AddRuns(const Point& at, ConfigurationFigures& of) const {
    for (std::uint64_t rep = 0; rep < file_.repeats(); ++rep) {
      const Ending ending = EndingOf(file_, {at, rep});
      ++of.repeats;
      if (ending.status != results::Status::kDone) {
        SetFault(of, ending.Word());
      } else if (!ending.IsKnown()) {
        SetFault(of, "no verdict");
      }
      if (ending.status == results::Status::kDone) of.noisy += IsNoisy(file_, {at, rep}) ? 1 : 0;
    }
    const protocol::Judgement worst = WorstEnding(file_, at).judgement;
    of.verdict = std::max(of.verdict, worst.verdict);
    if (worst.verdict > scene_.worst_verdict)
      SetFault(of, worst.first_bad_cycle < 0
                       ? std::string(protocol::VerdictName(worst.verdict))
                       : fmt::format("{} from cycle {}", protocol::VerdictName(worst.verdict),
                                     worst.first_bad_cycle));
  }

  void AddFigures(const MeasuredPoint& point, ConfigurationFigures& of) {
    of.time_step_s = model_.TimeStepOf(point);
    const PhaseTimes& steps = model_.times().Of(point, protocol::Phase::kStep);
    of.step_ns = std::fmax(of.step_ns, steps.mean.value);
    std::vector<double> sorted = steps.cycles;
    std::ranges::sort(sorted);
    of.slow_step_ns = std::fmax(of.slow_step_ns, Percentile(sorted, kSlowStep));
    of.memory_bytes = std::fmax(of.memory_bytes, model_.MemoryOf(point, "peak_rss"));
    const std::string dataset = "accuracy/" + std::string(scene_.error);
    for (const Cell& cell : point.cells) {
      const double error = file_.Has(dataset) ? file_.ReadReal(dataset, cell) : kNone;
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
    const MeasuredPoint* point = model_.Find(Point(file_.axes().size(), 0));
    const bool is_timed =
        std::isfinite(baseline.ms_per_s.value) && point != nullptr && point->IsSound();
    const std::string untimed = fmt::format("the baseline {} has no valid time", baseline.name);
    for (ConfigurationFigures& of : all) {
      if (!is_timed)
        SetFault(of, untimed);
      else if (baseline.IsNoisy() && of.fault.empty())
        SetDisturbed(of, fmt::format("the baseline {} is noisy", baseline.name));
      if (!is_timed || !std::isfinite(of.ms_per_s.value)) continue;
      of.speedup = RatioOf(baseline.ms_per_s, of.ms_per_s);
      of.speedup_interval = model_.times().IntervalOf(of.speedup);
    }
  }

  const StandardScene& scene_;
  const results::ResultFile& file_;
  const Model& model_;
};

/// `rubble: not run`, for each scene of the kind without results.
std::vector<std::string> FaultsOfMissing(const SuiteKind& kind,
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
  std::vector<Estimate> speedups;
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
  for (const Estimate& speedup : speedups)
    if (speedup.drawn.size() != speedups[0].drawn.size())
      throw files::StoreError(
          fmt::format("the scenes of {} have different numbers of repeats: their results are not "
                      "of one run of the suite",
                      scenes[0]->scene->kind));
  const Estimate score = GeometricMeanOf(speedups);
  of.score = score.value;
  of.interval = Bootstrap(score.things).IntervalOf(score);
  return of;
}

using Outcome = SceneVerification::Outcome;

/// Factor from which on an error is larger than another one.
constexpr double kUnlikeError = 2;
/// Fraction of the bound: smaller errors count as equal.
constexpr double kSmallError = 0.1;

std::string SpeedupText(const ConfigurationFigures& of) {
  const std::string value = fmt::format("{:.2f}", of.speedup.value);
  return std::isnan(of.speedup_interval.low)
             ? value
             : fmt::format("{} ({:.2f} .. {:.2f})", value, of.speedup_interval.low,
                           of.speedup_interval.high);
}

/// Disturbances of a run on this machine do not make it wrong.
bool IsWrong(const ConfigurationFigures& of, const StandardScene& scene) {
  return of.verdict > scene.worst_verdict || of.error > scene.bound ||
         of.verdict == protocol::Verdict::kUnknown;
}

bool HasOtherSpeedup(const ConfigurationFigures& claimed, const ConfigurationFigures& here,
                     double margin) {
  if (!claimed.HasScore() || !here.HasScore()) return false;
  const double apart = std::abs(std::log(claimed.speedup.value / here.speedup.value));
  return apart > std::log1p(margin) && !claimed.speedup_interval.Overlaps(here.speedup_interval);
}

void CompareConfigurations(const StandardScene& scene, const ConfigurationFigures& claimed,
                           const ConfigurationFigures& here, double margin,
                           std::vector<std::string>& disagreements) {
  if (claimed.HasScore() && IsWrong(here, scene))
    disagreements.push_back(
        fmt::format("{}: has a score, but here it is wrong: {}", claimed.name, here.fault));
  else if (here.error > kUnlikeError * claimed.error && here.error > kSmallError * scene.bound)
    disagreements.push_back(fmt::format("{}: {} error {}, here {}", claimed.name, scene.error,
                                        terminal::ShortNumber(claimed.error),
                                        terminal::ShortNumber(here.error)));
  if (HasOtherSpeedup(claimed, here, margin))
    disagreements.push_back(fmt::format("{}: speedup {}, here {}", claimed.name,
                                        SpeedupText(claimed), SpeedupText(here)));
}

std::string StatesText(const StateComparison& states) {
  const std::size_t known = states.same + states.other.size() + states.unsettled.size();
  std::string text = fmt::format("{} of {}", states.same, known);
  if (states.unknown > 0) text += fmt::format(", {} unknown", states.unknown);
  if (!states.unsettled.empty())
    text += fmt::format(", {} not repeatable", states.unsettled.size());
  return text;
}

}  // namespace

std::span<const SuiteKind> SuiteKinds() { return kKinds; }
std::span<const StandardScene> StandardScenes() { return kScenes; }

std::string StandardScene::Id() const { return fmt::format("{}/{}", kind, name); }
std::string StandardScene::File() const { return fmt::format("standard/{}/{}", kind, name); }
std::string StandardScene::ResultName() const { return fmt::format("standard_{}.h5", name); }

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

SceneFigures CollectScene(const StandardScene& scene, const Model& model) {
  return SceneCollector(scene, model).All();
}

std::vector<KindFigures> ScoreKinds(const std::vector<SceneFigures>& scenes) {
  std::vector<KindFigures> all;
  for (const SuiteKind& kind : SuiteKinds()) {
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
  const Bootstrap bootstrap(best.ms_per_s.things);
  const auto is_slower = [&](const ConfigurationFigures& of, const ConfigurationFigures& other) {
    // Without repeats there is no interval, and no tie.
    return !(bootstrap.IntervalOf(RatioOf(of.ms_per_s, other.ms_per_s)).low <= 1);
  };
  std::vector<const ConfigurationFigures*> recommended;
  for (const ConfigurationFigures* of : fitting)
    if (of == &best || std::ranges::none_of(fitting, [&](const ConfigurationFigures* other) {
          return of != other && is_slower(*of, *other);
        }))
      recommended.push_back(of);
  return recommended;
}

SceneVerification VerifyScene(const ScoredFile& claimed, const ScoredFile& here) {
  const StandardScene& scene = *claimed.figures.scene;
  SceneVerification made;
  made.scene = scene.Id();
  made.outcome = Outcome::kAgrees;
  if (claimed.of.file.plan_sha256() == here.of.file.plan_sha256()) {
    const auto states = CompareStates(claimed.of, here.of, MatchPoints(claimed.of, here.of));
    made.states = StatesText(states);
    if (states.other.empty() && states.unknown == 0) made.outcome = Outcome::kSameStates;
    if (!states.unsettled.empty())
      made.disagreements.push_back("repeats of one run end in different states");
  } else {
    made.states = "other seeds or detectors";
  }
  const bool is_same_cpu =
      claimed.of.file.ReadProvenance("cpu") == here.of.file.ReadProvenance("cpu");
  for (const ConfigurationFigures& of : claimed.figures.configurations)
    if (const ConfigurationFigures* other = here.figures.Find(of.name)) {
      if (of.HasScore()) ++made.claimed;
      if (of.HasScore() && other->HasScore()) ++made.timed;
      CompareConfigurations(scene, of, *other, is_same_cpu ? kLikeSpeedup : kUnlikeSpeedup,
                            made.disagreements);
    }
  if (!made.disagreements.empty()) made.outcome = Outcome::kDisagrees;
  return made;
}

}  // namespace cdb::figures
