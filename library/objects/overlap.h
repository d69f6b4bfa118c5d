// Whether two convex solids touch: exact up to rounding, and on the safe side where it is close.
#pragma once

#include "library/objects/solid.h"

namespace cdb::library {

/// False only where a separating plane was found; touching counts as overlap, and so does a gap
/// that is lost in rounding (below about 1e-12 of the solids' size). Source: E. G. Gilbert, D. W.
/// Johnson, S. S. Keerthi, IEEE J. Robotics and Automation 4 (1988); balls by their distance.
bool Overlap(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b);

}  // namespace cdb::library
