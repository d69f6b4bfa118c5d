// The distance of two solids, and the position at which one that moves along a direction reaches
// the other. In double, by the GJK algorithm for each pair of convex pieces.
//
// Rounding: a gap below about 1e-14 of the sizes of the solids and their offset counts as none.
// Threads: any. Source: E. G. Gilbert, D. W. Johnson, S. S. Keerthi, IEEE J. Robotics and
// Automation 4 (1988); balls by their centres.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "library/objects/solid.h"

namespace cdb::objects {

/// m; 0 if they touch or overlap, exactly when Overlap returns true. Exact to 1e-12 of sizes and
/// distance.
double Distance(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b);

/// The distance of b's centre of mass from a's when b, coming from afar against `direction` (unit,
/// from a to b) without rotation, first is `distance` m away from a. Empty if it passes by. Never
/// closer than requested, and exact to 1e-12 of sizes and distance. Each step is the remaining
/// distance divided by its rate of change, which only grows outwards, so that a step never
/// overshoots a convex solid. The positions in the poses are ignored.
std::optional<double> Approach(const Solid& a, const Pose& pose_a, const Solid& b,
                               const Pose& pose_b, const Eigen::Vector3d& direction,
                               double distance);

// Overlap test of two solids: exact up to rounding, and conservative in close cases.

/// False only if a separating plane was found, for compounds one between each pair of pieces;
/// touching counts as overlap, and so does a gap that is lost in rounding
/// (library/objects/distance.h).
bool Overlap(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b);

}  // namespace cdb::objects
