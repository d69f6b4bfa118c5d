// The distance of two solids, and the position at which one that moves along a direction reaches
// the other. In double, by the GJK algorithm for each pair of convex pieces.
//
// Rounding: a gap below about 1e-14 of the sizes of the solids and their offset counts as none.
// Threads: any. Source: E. G. Gilbert, D. W. Johnson, S. S. Keerthi, IEEE J. Robotics and
// Automation 4 (1988); balls by their centres.
#pragma once

#include <Eigen/Core>
#include <limits>
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

// Penetration depth and axis of two solids in closed form, in double: the ground truth for
// contacts.
//
// Threads: any. Source of the axes of two cuboids: S. Gottschalk et al., OBBTree, 1996.

/// Moving the first by `depth` along `normal` is the shortest displacement that separates the two.
struct Penetration {
  double depth = 0;                                   ///< m; negative: the distance between them
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from the second to the first
  /// m: of the shortest displacement along any other candidate in a different direction (by more
  /// than a thousandth of a radian); infinite if there is none. If it equals `depth`, the normal is
  /// not unique.
  double next_depth = std::numeric_limits<double>::infinity();
};

/// Exact up to rounding for two balls, for a ball and a cuboid, with the ball's centre outside or
/// inside, and for two cuboids that touch or overlap. Nullopt for all other pairs, including two
/// separate cuboids, whose distance no axis gives.
std::optional<Penetration> ExactContact(const Solid& a, const Pose& pose_a, const Solid& b,
                                        const Pose& pose_b);

/// The contact of a solid and the half space {x : normal . x <= offset}, its normal unit, its
/// offset in m. Exact except for compounds, which give nullopt.
std::optional<Penetration> ExactContact(const Solid& solid, const Pose& pose,
                                        const Eigen::Vector3d& normal, double offset);

}  // namespace cdb::objects
