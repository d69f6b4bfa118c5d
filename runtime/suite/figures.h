// The figures of the standard suite: times, errors and memory of each configuration of a scene, and
// a score for each configuration and kind of application (`cdb doc suite`).
//
// A configuration is a point on all axes of a scene but that of seeds, called by its values:
// `dbvt`, `steps_240`. The first one is the baseline, which is what Bullet does unless it is told
// otherwise. The score of a configuration is the geometric mean, over the scenes of a kind, of the
// baseline's time for a simulated second over its own. A configuration that is wrong in one scene
// has no score in that kind.
//
// Not for several threads.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/statistics/bootstrap.h"
#include "runtime/store/store.h"
#include "runtime/suite/standard.h"
#include "runtime/terminal/numbers.h"

namespace cdb::suite {

struct ConfigurationFigures {
  std::string name;
  bool is_bullets_own = false;  ///< its detector is one of Bullet's, or it names no detector
  std::string fault;            ///< why it has no score; empty for most
  bool is_disturbed = false;  ///< the fault is of the machine alone, and the same run may be right
  measure::Verdict verdict = measure::Verdict::kUnknown;  ///< the worst of its repeats
  std::size_t repeats = 0, noisy = 0;
  double error = terminal::kNone;         ///< the largest over the seeds
  double memory_bytes = terminal::kNone;  ///< peak resident memory, the most of its repeats
  double time_step_s = terminal::kNone;
  double step_ns = terminal::kNone;  ///< the mean
  double slow_step_ns =
      terminal::kNone;  ///< 99th percentile of the cycles, each the median of its repeats
  /// Of a simulated second; over the time of the baseline. Without a value where there is no time.
  statistics::Estimate ms_per_s = {terminal::kNone, {}, 0}, speedup = {terminal::kNone, {}, 0};
  statistics::Interval speedup_interval = {terminal::kNone, terminal::kNone};

  bool HasScore() const { return fault.empty(); }
  /// Most of its repeats were disturbed.
  bool IsNoisy() const { return 2 * noisy > repeats; }
  /// A step, or as many as fill the period, takes no longer than the period.
  bool Fits(double period_s) const;
};

struct SceneFigures {
  const StandardScene* scene = nullptr;
  std::string title;
  std::size_t seeds = 1;
  std::vector<ConfigurationFigures> configurations;  ///< the first is the baseline; not empty

  const ConfigurationFigures* Find(const std::string& name) const;
  /// It has a score, and no other one with a score is as fast and as accurate, and better in one.
  bool IsOnFront(const ConfigurationFigures& of) const;
};
/// `file` must be of a plan that this cdb can read. Throws StoreError.
SceneFigures CollectScene(const StandardScene& scene, const store::ResultFile& file);

/// A configuration in a kind.
struct KindScore {
  std::string name;
  double score = terminal::kNone;  ///< NaN where it has none
  statistics::Interval interval = {terminal::kNone, terminal::kNone};
  double memory_bytes = terminal::kNone;  ///< the most over the scenes
  std::vector<std::string> faults;        ///< `bounce: drifting from cycle 12`
};

struct KindFigures {
  const Kind* kind = nullptr;
  std::vector<const SceneFigures*> scenes;  ///< those that there are
  std::string baseline;
  std::vector<KindScore> scores;  ///< the highest first, then those without
};
/// Kinds without a scene in `scenes`, which must outlive them, are left out.
std::vector<KindFigures> ScoreKinds(const std::vector<SceneFigures>& scenes);

/// Time for a frame or for a step of a haptic device.
struct Budget {
  std::string_view name;  ///< `1/60 s`
  double seconds;
};
inline constexpr Budget kBudgets[] = {{"1/30 s", 1.0 / 30}, {"1/60 s", 1.0 / 60}, {"1 ms", 0.001}};

/// Of the configurations that are right and fit into `period_s`, those of least error; the fastest
/// of them first, then those that cannot be told from it: the interval of the ratio of their times
/// includes 1. Empty where none fits. `only_bullets_own`: is_bullets_own.
std::vector<const ConfigurationFigures*> Recommend(const SceneFigures& scene, double period_s,
                                                   bool only_bullets_own);

}  // namespace cdb::suite
