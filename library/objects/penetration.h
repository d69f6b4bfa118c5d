// Penetration depth and axis of two solids in closed form, in double: the ground truth for
// contacts.
//
// Threads: any. Source of the axes of two cuboids: S. Gottschalk et al., OBBTree, 1996.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "library/objects/solid.h"

namespace cdb::objects {

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
