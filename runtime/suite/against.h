// Verifies one machine's results of the standard suite by another's (`cdb suite --against`): states
// to the last bit if the builds are the same, errors and speedups within their intervals if they
// are not.
#pragma once

#include <string>
#include <vector>

#include "runtime/compare/match.h"
#include "runtime/suite/figures.h"

namespace cdb::suite {

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
  const compare::ComparedFile& of;
  const SceneFigures& figures;
};
/// Verifies `claimed` by `here`. If their seeds differ, states are not compared. Throws StoreError.
SceneVerification VerifyScene(const ScoredFile& claimed, const ScoredFile& here);

/// Differences of speedups that are accepted beyond their intervals, for processors of the same and
/// of different kinds.
inline constexpr double kLikeSpeedup = 0.1, kUnlikeSpeedup = 0.5;

std::string VerificationText(const std::vector<SceneVerification>& scenes);

}  // namespace cdb::suite
