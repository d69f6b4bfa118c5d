// Distance of two solids, and how close one can come to the other along a direction. In double, by
// the GJK algorithm for each pair of convex pieces.
//
// Rounding: a gap below about 1e-14 of the solids' sizes and their offset counts as none. Threads:
// any. Source: E. G. Gilbert, D. W. Johnson, S. S. Keerthi, IEEE J. Robotics and Automation 4
// (1988); balls by their centres.
#pragma once

#include <optional>

#include "library/objects/solid.h"

namespace cdb::objects {

/// m; 0 where they touch or overlap, which is just where Overlap says so. Exact to 1e-12 of sizes
/// and distance.
double Distance(const Solid& a, const Pose& pose_a, const Solid& b, const Pose& pose_b);

/// How far from a's centre of mass b's is where b, coming from afar against `direction` (unit, from
/// a to b) without turning, is first `distance` m away from a. Empty where it passes by. Never
/// nearer than asked, and exact to 1e-12 of sizes and distance, by steps that no convex solid can
/// use up: each is the distance that is left over its rate of change, which only grows outwards.
/// The poses' positions are not looked at.
std::optional<double> Approach(const Solid& a, const Pose& pose_a, const Solid& b,
                               const Pose& pose_b, const Eigen::Vector3d& direction,
                               double distance);

}  // namespace cdb::objects
