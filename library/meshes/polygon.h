// Polygons become triangles by clipping ears.
//
// A polygon that is convex as seen from its first corner becomes the fan about it. Any other is
// projected along its normal; a polygon may touch itself, as one with a hole does along the bridge
// to the hole. Each edge of the polygon is an edge of one triangle whatever the polygon, so that a
// closed mesh stays closed; the triangles overlap only if the polygon crosses itself. O(n) for
// fans, otherwise O(n r) with r reflex corners. Errors: none. Threads: any.
// Sources: Meisters, "Polygons have ears", Am. Math. Monthly 82(6), 1975; Eberly, "Triangulation by
// ear clipping", 2002; the normal by Newell's method, Sutherland et al. 1974.
#pragma once

#include <span>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

/// Appends the triangles of a polygon with 3 corners or more, which are indices of `vertices`.
void Triangulate(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3d> vertices,
                 std::vector<Triangle>& triangles);

/// A polygon with more corners is rejected if it is not a fan.
inline constexpr std::size_t kMaxCorners = 20'000;

/// True if the fan about the first corner folds nowhere.
bool IsFan(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3d> vertices);

}  // namespace cdb::meshes
