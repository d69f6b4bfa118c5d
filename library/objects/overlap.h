// Whether two solids overlap: exact up to rounding, and conservative in close cases.
#pragma once

#include "library/objects/solid.h"

namespace cdb::objects {

/// False only where a separating plane was found, for compounds one between each two pieces;
/// touching counts as overlap, and so does a gap that is lost in rounding
/// (library/objects/distance.h).
bool Overlap(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b);

}  // namespace cdb::objects
