// Overlap test of two solids: exact up to rounding, and conservative in close cases.
#pragma once

#include "library/objects/solid.h"

namespace cdb::objects {

/// False only if a separating plane was found, for compounds one between each pair of pieces;
/// touching counts as overlap, and so does a gap that is lost in rounding
/// (library/objects/distance.h).
bool Overlap(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b);

}  // namespace cdb::objects
