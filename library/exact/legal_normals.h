// The normals that contacts with a surface may have, by its triangles: the referee of contacts with
// ground. In double, without any physics engine. Threads: any.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "library/objects/compound.h"

namespace cdb::exact {

/// The unit vector nearest to `normal` (unit) that a contact with the surface within `reach` m of
/// `point` may have, in the axes of the surface; nullopt if no triangle is within reach.
///
/// The normals of a face are legal on both sides. At any point, so is a normal if no triangle that
/// meets there rises above the plane through the point: on a convex edge those between its faces,
/// on a convex corner those of its cone, on an open edge those of a half circle. On a coplanar or a
/// concave edge, only those of the faces are. Triangles meet where their positions agree to a
/// hundred thousandth of the surface's longest side, whether or not they share vertices.
/// Source: normal cones, Rockafellar, Convex Analysis, 1970, section 2.
std::optional<Eigen::Vector3d> NearestLegalNormal(const objects::Compound& surface,
                                                  const Eigen::Vector3d& point,
                                                  const Eigen::Vector3d& normal, double reach);

}  // namespace cdb::exact
