// The verdict of a run: whether the simulation was sound, and the first cycle at which it was not.
// Computed from the recorded series only, so that a crashed run has a verdict too. The criteria
// were found by measurement; `cdb doc verdicts` prints the table.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"
#include "compiler/schema/verdicts.h"
#include "runtime/protocol/recording.h"

namespace cdb::protocol {

using Verdict = schema::Verdict;
using VerdictInfo = schema::VerdictInfo;
std::span<const VerdictInfo> Verdicts();
std::string_view VerdictName(Verdict verdict);

/// True if bodies did not move as the engine was told: the time of a cycle is not that of this
/// scene. Such timings are stored, but left out of every summary.
constexpr bool HasVoidTimings(Verdict verdict) { return verdict >= Verdict::kFrozen; }

struct Judgement {
  Verdict verdict = Verdict::kUnknown;
  std::int64_t first_bad_cycle = -1;  ///< recorded cycles from 0; -1 if none is bad
  /// The number of objects, or pairs of them, to which the verdict applies; -1 for a verdict on the
  /// scene as a whole, such as a gain of energy.
  std::int64_t bad_objects = -1;
  /// The series that shows it: of the criteria of the verdict, that which was met first. Empty if
  /// there is none, or in results of earlier versions.
  std::string criterion = {};
};
/// `drifting (friction_error)`; `frozen`, which is a series of the same name.
std::string VerdictText(const Judgement& judgement);

/// Judges a run from the recording of its first `n_cycles` cycles. `outcome` is the ending of its
/// process if that is a verdict (kTimedOut, kCrashed), else kUnknown. The first bad cycle of a
/// crash or a timeout is the one that was not finished.
Judgement Judge(const plan::Scene& scene, const Recording& recording, std::uint64_t n_cycles,
                Verdict outcome = Verdict::kUnknown);

}  // namespace cdb::protocol
