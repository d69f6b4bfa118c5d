// THE table of verdicts: whether the simulation of a run was sound. Results, `cdb doc verdicts` and
// the checker of requirements read it; runtime/protocol/verdict.h applies the criteria.
#pragma once

#include <cstdint>
#include <string_view>

namespace cdb::schema {

/// `flag_values` of the array `verdict`, in this order: later values are worse. The worst one that
/// applies is reported.
enum class Verdict : std::int8_t {
  kUnknown,  ///< the run did not start, or `record` lacks stability
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

/// One row of the table of verdicts.
struct VerdictInfo {
  Verdict verdict;
  std::string_view name;  ///< `non_finite`
  std::string_view doc;   ///< the criterion, in one line
};

/// In the order of Verdict.
inline constexpr VerdictInfo kVerdicts[] = {
    {Verdict::kUnknown, "unknown", "the run was not executed, or did not record stability"},
    {Verdict::kStable, "stable", "none of the above"},
    {Verdict::kDrifting, "drifting",
     "energy rose by 0.01, or was gained or lost by 0.1; false normals of the ground deflected an "
     "object; friction or rolling was off by 0.05, or friction turned an object by > 0.1 rad that "
     "lay flat; impacts were off by an eighth; a motor with effort left is late off by a tenth of "
     "its speed, or by 0.1 rad or 0.1 S; a link of soft_world positions is stretched by > 0.1; if "
     "the scene "
     "must rest, late speed > 0.02 sqrt(g "
     "S), "
     "or an object moved by > 0.25 S"},
    {Verdict::kPenetrating, "penetrating",
     "late depth or joint gap > 0.05 S; joints late bent by > 0.05 rad or stretched by > 0.02; "
     "pressed in; nodes of a soft body end inside a rigid one, a body crosses itself, or a "
     "tetrahedron ends inside out; or, if the scene must rest, any depth > 0.25 S"},
    {Verdict::kCollapsed, "collapsed",
     "the scene must rest, and at least 1 % of its objects moved by > 0.25 S; a load ends below "
     "its support; an object sleeps unheld"},
    {Verdict::kClamped, "clamped",
     "an object turned by less than 0.9 of its spin times the time step, or is frozen"},
    {Verdict::kTunnelled, "tunnelled",
     "an object passed through another, or its centre of mass is beyond a wall at the end, unless "
     "it fell over the edge of a floor"},
    {Verdict::kExploded, "exploded", "energy rose by more than its scale"},
    {Verdict::kFrozen, "frozen",
     "rounding changes the motion of at least 1 % of the objects by a tenth"},
    {Verdict::kRemoved, "removed",
     "a box, extended by its displacement, exceeds 1e6 m, or Bullet disabled the object"},
    {Verdict::kNonFinite, "non_finite", "the state of an object is not finite"},
    {Verdict::kTimedOut, "timed_out", "the run exceeded its timeout"},
    {Verdict::kCrashed, "crashed", "the process of the run ended abnormally"},
};

}  // namespace cdb::schema
