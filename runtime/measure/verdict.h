// The verdict of a run: whether the simulation was sound, and the first cycle at which it was not.
// Computed from the recorded series alone, so that a run that crashed has one too. The criteria
// were found by measurement; `cdb doc verdicts` prints the table.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "compiler/plan/plan.h"
#include "runtime/measure/recording.h"

namespace cdb::measure {

/// `flag_values` of the array `verdict`, in this order: the later, the worse; the worst that
/// applies is given.
enum class Verdict : std::int8_t {
  kUnknown,  ///< it did not run, or `record` has no stability
  kStable,
  kDrifting,
  kPenetrating,
  kCollapsed,
  kClamped,
  kTunnelled,
  kExploded,
  kFrozen,
  kRemoved,
  kNonFinite,
  kTimedOut,
  kCrashed,
};

/// One row of THE table of verdicts.
struct VerdictInfo {
  Verdict verdict;
  std::string_view name;  ///< `non_finite`
  std::string_view doc;   ///< the criterion, one line
};
std::span<const VerdictInfo> Verdicts();
std::string_view VerdictName(Verdict verdict);

/// Bodies did not move as the engine was told: what a cycle took is no time of this scene. Stored,
/// and left out of every summary.
constexpr bool HasVoidTimings(Verdict verdict) { return verdict >= Verdict::kFrozen; }

struct Judgement {
  Verdict verdict = Verdict::kUnknown;
  std::int64_t first_bad_cycle = -1;  ///< recorded cycles from 0; -1 where none is bad
};

/// What the recording of a run says that went through its first `n_cycles` cycles; `outcome` is how
/// its process ended as far as that is a verdict of its own (kTimedOut, kCrashed), else kUnknown.
/// A crash or a timeout shows at the cycle that was not finished.
Judgement Judge(const plan::Scene& scene, const Recording& recording, std::uint64_t n_cycles,
                Verdict outcome = Verdict::kUnknown);

}  // namespace cdb::measure
