// One machine's results of the standard suite verified by another's (`cdb suite --against`): states
// to the last bit where the builds are the same, errors and speedups within their intervals where
// they are not.
#pragma once

#include <string>
#include <vector>

#include "runtime/compare/match.h"
#include "runtime/suite/figures.h"

namespace cdb::suite {

/// How the results of a scene stand to those of another machine.
struct SceneVerification {
  enum class Outcome {
    kSameStates,  ///< every run ended in the same state, to the last bit
    kAgrees,      ///< other states, and errors, verdicts and speedups agree
    kDisagrees,   ///< something is claimed that the other results do not bear out
  };
  std::string scene;
  Outcome outcome = Outcome::kSameStates;
  std::string states;  ///< `30 of 30 the same`
  /// Configurations with a score in the claimed results, and those of them that have one here.
  std::size_t claimed = 0, timed = 0;
  std::vector<std::string> disagreements;  ///< `skin: speedup 1.90 (1.88 .. 1.92), here 1.40 (…)`
};

/// A scene's results, and the figures of them.
struct ScoredFile {
  const compare::ComparedFile& of;
  const SceneFigures& figures;
};
/// Verifies `claimed` by `here`. Where their seeds differ, states are not compared. Throws
/// StoreError.
SceneVerification VerifyScene(const ScoredFile& claimed, const ScoredFile& here);

/// Speedups may differ by so much, beyond their intervals, on processors of one kind and of two.
inline constexpr double kLikeSpeedup = 0.1, kUnlikeSpeedup = 0.5;

std::string VerificationText(const std::vector<SceneVerification>& scenes);

}  // namespace cdb::suite
