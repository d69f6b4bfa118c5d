// Convex hulls of points.
//
// Lengths in the unit of the points. Deterministic: the same points in the same order give the same
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

/// The corners of a convex solid, without redundant points, in the order of the input points.
struct Hull {
  std::vector<Eigen::Vector3d> vertices;
  bool operator==(const Hull&) const = default;
};

/// Nullopt if the points are flat: in a plane up to rounding, on a line, or fewer than 4.
std::optional<Hull> TryConvexHull(std::span<const Eigen::Vector3d> points);
/// The hull of the faces, or of all vertices of a mesh without faces. Rejects flat meshes.
Hull ConvexHull(const Mesh& mesh, std::string_view name);
/// Its boundary, closed and counter-clockwise from outside, with the vertices of the hull.
Mesh SurfaceOf(const Hull& hull);

/// At most `count` of the vertices, 4 or more: starting from a large tetrahedron, the next one is
/// always the farthest outside the hull so far. The hull itself if it has no more vertices than
/// that.
Hull WithFewerVertices(const Hull& hull, std::size_t count);

/// The version of the library that computes them.
std::string_view ConvexHullVersion();

}  // namespace cdb::meshes
