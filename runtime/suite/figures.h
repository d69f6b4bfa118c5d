// The figures of the standard suite: times, errors and memory of each configuration of a scene, and
// a score for each configuration and kind of application (`cdb doc suite`).
//
// A configuration is a point on all axes of a scene except that of seeds, named by its values:
// `dbvt`, `steps_240`. The first one is the baseline: Bullet's defaults. The score of a
// configuration is the geometric mean, over the scenes of a kind, of the baseline's time for a
// simulated second over its own. A configuration that is wrong in one scene has no score in that
// kind.
//
// Not thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/numbers.h"
#include "runtime/store/store.h"
#include "runtime/suite/standard.h"

namespace cdb::suite {

struct ConfigurationFigures {
  std::string name;
  bool is_bullets_own = false;  ///< its detector is one of Bullet's, or it names no detector
  std::string fault;            ///< reason why it has no score; empty for most
  bool is_disturbed = false;  ///< the only fault is a disturbance by the machine; the same run may
                              ///< be right
  measure::Verdict verdict = measure::Verdict::kUnknown;  ///< the worst of its repeats
  std::size_t repeats = 0, noisy = 0;
  double error = figures::kNone;         ///< the largest over the seeds
  double memory_bytes = figures::kNone;  ///< peak resident memory, the maximum of its repeats
  double time_step_s = figures::kNone;
  double step_ns = figures::kNone;       ///< the mean
  double slow_step_ns = figures::kNone;  ///< 99th percentile of the cycles, each of which is the
                                         ///< median of its repeats
  /// Time for a simulated second, and the baseline's time over it. NaN if there is no time.
  figures::Estimate ms_per_s = {figures::kNone, {}, 0}, speedup = {figures::kNone, {}, 0};
  figures::Interval speedup_interval = {figures::kNone, figures::kNone};

  bool HasScore() const { return fault.empty(); }
  /// True if most of its repeats were disturbed.
  bool IsNoisy() const { return 2 * noisy > repeats; }
  /// True if a step, or as many steps as make up the period, takes no longer than the period.
  bool Fits(double period_s) const;
};

struct SceneFigures {
  const StandardScene* scene = nullptr;
  std::string title;
  std::size_t seeds = 1;
  std::vector<ConfigurationFigures> configurations;  ///< the first is the baseline; not empty

  const ConfigurationFigures* Find(const std::string& name) const;
  /// True if it has a score, and no other one with a score is at least as fast and as accurate, and
  /// better in one of the two.
  bool IsOnFront(const ConfigurationFigures& of) const;
};
/// `file` must have a plan that this cdb can read. Throws StoreError.
SceneFigures CollectScene(const StandardScene& scene, const store::ResultFile& file);

/// The score of a configuration in a kind.
struct KindScore {
  std::string name;
  double score = figures::kNone;  ///< NaN if it has none
  figures::Interval interval = {figures::kNone, figures::kNone};
  double memory_bytes = figures::kNone;  ///< the maximum over the scenes
  std::vector<std::string> faults;       ///< `bounce: drifting from cycle 12`
};

struct KindFigures {
  const Kind* kind = nullptr;
  std::vector<const SceneFigures*> scenes;  ///< those with results
  std::string baseline;
  std::vector<KindScore> scores;  ///< the highest first, then those without a score
};
/// Leaves out kinds without a scene in `scenes`, which must outlive the result.
std::vector<KindFigures> ScoreKinds(const std::vector<SceneFigures>& scenes);

/// The time budget of a frame, or of a step of a haptic device.
struct Budget {
  std::string_view name;  ///< `1/60 s`
  double seconds;
};
inline constexpr Budget kBudgets[] = {{"1/30 s", 1.0 / 30}, {"1/60 s", 1.0 / 60}, {"1 ms", 0.001}};

/// The configurations of least error among those that are right and fit into `period_s`: first the
/// fastest of them, then those that tie with it: none of them is slower than another beyond the
/// interval, that is, the interval of the ratio of their times includes 1. Empty if none fits.
/// `only_bullets_own`: only those with is_bullets_own.
std::vector<const ConfigurationFigures*> Recommend(const SceneFigures& scene, double period_s,
                                                   bool only_bullets_own);

}  // namespace cdb::suite
