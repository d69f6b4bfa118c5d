// The normals that contacts with a surface may have, by its triangles: the referee of contacts with
// ground. In double, without any physics engine. Threads: any.
#pragma once

#include <Eigen/Core>
#include <functional>
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

/// Whether a point (m) is in a region of space.
using Region = std::function<bool(const Eigen::Vector3d&)>;

/// The same for ground made of convex solids, such as tiles of a floor and the hulls of a mesh.
/// `own` is the solid that has the contact and `others` are those around it. Of the solid alone,
/// the normal is taken to be legal; the result is nearest to it of those along which no other solid
/// rises within `radius` of the contact: zero if all around it is covered; nullopt if the point is
/// not within `reach` of the surface of `own`. Where solids meet at a concave edge, the normals
/// beside it are legal. Elevations are resolved to about 0.01 rad.
std::optional<Eigen::Vector3d> NearestLegalNormal(const Region& own, const Region& others,
                                                  const Eigen::Vector3d& point,
                                                  const Eigen::Vector3d& normal, double reach,
                                                  double radius);

}  // namespace cdb::exact
