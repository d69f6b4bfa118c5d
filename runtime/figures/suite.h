// The scenes of the standard suite, and the figures of their results (`cdb doc suite`): times,
// errors and memory of each configuration of a scene, a score for each configuration and kind of
// application, and whether another machine's results agree (`cdb suite --against`): states to the
// last bit if the builds are the same, errors and speedups within their intervals if they are not.
//
// A configuration is a point on all axes of a scene except that of seeds. It is named by its value
// on the first of them, and by its values on the others unless they are the baseline's: `dbvt`,
// `steps_240`, `auto + batch`. The first one is the baseline: Bullet's defaults. The score of a
// configuration is the geometric mean, over the scenes of a kind, of the baseline's time for a
// simulated second over its own. A configuration that is wrong in one scene has no score in that
// kind.
//
// Not thread-safe.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/figures/compare.h"
#include "runtime/protocol/verdict.h"

namespace cdb::figures {

/// Increase it with every change of a scene, of a bound or of the score: results of different
/// versions are not comparable. tests/golden/suite/ has the plans of each version.
inline constexpr int kSuiteVersion = 5;

/// A kind of application. Its scenes sweep the same configurations.
struct SuiteKind {
  std::string_view name;  ///< the folder below `standard/` in the library of scenarios
  std::string_view doc;
};
std::span<const SuiteKind> SuiteKinds();

struct StandardScene {
  std::string_view kind, name;
  std::string_view what;   ///< for people: `3000 pieces of debris in orbit`
  std::string_view error;  ///< name of its array in /accuracy
  double bound;            ///< a run with a larger error is wrong
  /// A run with a worse verdict is wrong too.
  protocol::Verdict worst_verdict = protocol::Verdict::kStable;

  /// `games/debris`
  std::string Id() const;
  /// Its name in the library of scenarios: `standard/games/debris`.
  std::string File() const;
  /// `standard_debris.h5`
  std::string ResultName() const;
};
/// Grouped by kind, in the order of SuiteKinds.
std::span<const StandardScene> StandardScenes();

struct ConfigurationFigures {
  std::string name;
  bool is_bullets_own = false;  ///< its detector and narrow phase are Bullet's, or not named
  std::string fault;            ///< reason why it has no score; empty for most
  bool is_disturbed = false;  ///< the only fault is a disturbance by the machine; the same run may
                              ///< be right
  protocol::Verdict verdict = protocol::Verdict::kUnknown;  ///< the worst of its repeats
  std::size_t repeats = 0, noisy = 0;
  double error = kNone;         ///< the largest over the seeds
  double memory_bytes = kNone;  ///< peak resident memory, the maximum of its repeats
  double time_step_s = kNone;
  double step_ns = kNone;       ///< the mean
  double slow_step_ns = kNone;  ///< 99th percentile of the cycles, each of which is the
                                ///< median of its repeats
  /// Time for a simulated second, and the baseline's time over it. NaN if there is no time.
  Estimate ms_per_s = {kNone, {}, 0}, speedup = {kNone, {}, 0};
  Interval speedup_interval = {kNone, kNone};

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
/// The file must have a plan that this cdb can read. Throws StoreError.
SceneFigures CollectScene(const StandardScene& scene, const Model& model);

/// The score of a configuration in a kind.
struct KindScore {
  std::string name;
  double score = kNone;  ///< NaN if it has none
  Interval interval = {kNone, kNone};
  double memory_bytes = kNone;      ///< the maximum over the scenes
  std::vector<std::string> faults;  ///< `bounce: drifting from cycle 12`
};

struct KindFigures {
  const SuiteKind* kind = nullptr;
  std::vector<const SceneFigures*> scenes;  ///< those with results
  std::string baseline;
  std::vector<KindScore> scores;  ///< the highest first, then those without a score
};
/// Leaves out kinds without a scene in `scenes`, which must outlive the result.
std::vector<KindFigures> ScoreKinds(const std::vector<SceneFigures>& scenes);

/// The time budget of a frame, or of a step of a haptic device.
struct TimeBudget {
  std::string_view name;  ///< `1/60 s`
  double seconds;
};
inline constexpr TimeBudget kTimeBudgets[] = {
    {"1/30 s", 1.0 / 30}, {"1/60 s", 1.0 / 60}, {"1 ms", 0.001}};

/// The configurations of least error among those that are right and fit into `period_s`: first the
/// fastest of them, then those that tie with it: none of them is slower than another beyond the
/// interval, that is, the interval of the ratio of their times includes 1. Empty if none fits.
/// `only_bullets_own`: only those with is_bullets_own.
std::vector<const ConfigurationFigures*> Recommend(const SceneFigures& scene, double period_s,
                                                   bool only_bullets_own);

/// The result of verifying a scene against another machine's results.
struct SceneVerification {
  enum class Outcome {
    kSameStates,  ///< every run ended in the same state, to the last bit
    kAgrees,      ///< states differ, but errors, verdicts and speedups agree
    kDisagrees,   ///< the other results do not bear out some claim
  };
  std::string scene;
  Outcome outcome = Outcome::kSameStates;
  std::string states;  ///< `30 of 30 the same`
  /// Configurations with a score in the claimed results, and the number of them with a score here.
  std::size_t claimed = 0, timed = 0;
  std::vector<std::string> disagreements;  ///< `skin: speedup 1.90 (1.88 .. 1.92), here 1.40 (…)`
};

/// The results of a scene with their figures.
struct ScoredFile {
  const ComparedFile& of;
  const SceneFigures& figures;
};
/// Verifies `claimed` by `here`. If their seeds differ, states are not compared. Throws StoreError.
SceneVerification VerifyScene(const ScoredFile& claimed, const ScoredFile& here);

/// Differences of speedups that are accepted beyond their intervals, for processors of the same and
/// of different kinds.
inline constexpr double kLikeSpeedup = 0.1, kUnlikeSpeedup = 0.5;

}  // namespace cdb::figures
