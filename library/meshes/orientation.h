// The directions of the faces of a closed mesh: consistent, and outwards.
//
// Errors: SceneError that begins with `name`. Threads: any.
// Source: each edge of an oriented closed surface occurs equally often in each direction.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

/// An edge of a face.
struct FaceEdge {
  std::uint32_t low, high;  ///< its vertices
  std::uint32_t face;
  bool rises;  ///< runs from low to high
};

/// The edges of all faces; equal ones are adjacent, in the order of their faces.
std::vector<FaceEdge> SortedEdges(const Mesh& mesh);

/// Calls `visit` with each range of equal edges.
template <typename Visit>
void ForEachEdge(std::span<const FaceEdge> edges, const Visit& visit) {
  for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
    for (end = begin; end < edges.size() && edges[end].low == edges[begin].low &&
                      edges[end].high == edges[begin].high;)
      ++end;
    visit(edges.subspan(begin, end - begin));
  }
}

/// `(1, 0, 0) to (1, 2, 0)`.
std::string Written(const Mesh& mesh, const FaceEdge& edge);
std::string Written(const Eigen::Vector3d& point);

/// Turns faces of a mesh each of whose edges has an even number of them. A shell is the smallest
/// set of faces that is connected by edges and closed. In a shell whose faces disagree, neighbours
/// are made to agree (at an edge of four faces or more, neighbours by angle), and it becomes a
/// cavity if it is within a larger shell, or else a solid. Any other shell stays as it is, unless
/// that leaves it inside out in no larger one: then it is turned, with all within it. Rejects
/// one-sided surfaces.
void Orient(Mesh& mesh, std::string_view name);

}  // namespace cdb::meshes
