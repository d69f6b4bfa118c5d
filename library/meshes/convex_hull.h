// Convex hulls of points.
//
// Lengths in the points' unit. Deterministic: the same points in the same order give the same
// bytes. Errors: SceneError that begins with `name`. Threads: any. Source: Barber, Dobkin &
// Huhdanpaa, "The Quickhull algorithm for convex hulls", ACM TOMS 22(4), 1996, by their Qhull
// 2020.2 (Debian's libqhull-dev).
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

/// The corners of a convex solid, each a corner indeed, in the order of the points that it is of.
struct Hull {
  std::vector<Eigen::Vector3d> vertices;
  bool operator==(const Hull&) const = default;
};

/// Nothing where the points are flat: in a plane up to rounding, on a line, or fewer than 4.
std::optional<Hull> TryConvexHull(std::span<const Eigen::Vector3d> points);
/// Of all vertices. Refuses flat meshes.
Hull ConvexHull(const Mesh& mesh, std::string_view name);
/// Its boundary, closed and counter-clockwise from outside; the vertices are the hull's.
Mesh SurfaceOf(const Hull& hull);

/// At most `count` of the vertices, 4 or more: starting from a large tetrahedron, each next is the
/// one farthest outside of the hull so far. The hull itself where it has no more.
Hull WithFewerVertices(const Hull& hull, std::size_t count);

/// Of the library that computes them.
std::string_view ConvexHullVersion();

}  // namespace cdb::meshes
