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

/// Moving the first by `depth` along `normal` is the least move that parts the two.
struct Penetration {
  double depth = 0;                                   ///< m; negative: how far they are apart
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, from the second to the first
  /// m: of the least move along any other candidate that is not nearly the same way (a thousandth
  /// of a radian); infinite where there is none. As good as `depth`: the normal is one of several.
  double next_depth = std::numeric_limits<double>::infinity();
};

/// Exact up to rounding for two balls, for a ball and a cuboid, the ball's centre outside or
/// inside, and for two cuboids that touch or overlap. Nullopt for all others, among them two
/// cuboids that are apart, whose distance no axis tells.
std::optional<Penetration> ExactContact(const Solid& a, const Pose& pose_a, const Solid& b,
                                        const Pose& pose_b);

/// Of a solid and the half space {x : normal . x <= offset}, its normal unit, its offset in m.
/// Exact for all but compounds, for which it is nullopt.
std::optional<Penetration> ExactContact(const Solid& solid, const Pose& pose,
                                        const Eigen::Vector3d& normal, double offset);

}  // namespace cdb::objects
