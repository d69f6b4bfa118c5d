// The primitives of a deforming mesh as bodies of a broad phase: its triangles in each frame, or
// its vertices and faces, or its edges, each swept over the step from one frame to the next.
//
// Two primitives that share a vertex always touch there; they are neighbours and never a pair.
// Boxes are the exact bounds of the vertices: those of a step contain the linear motion between its
// frames, as a convex combination lies between its ends.
//
// Sources: Provot, "Collision and self-collision handling in cloth model dedicated to design
// garments" (Graphics Interface 1997) for the pairs of a step; the pairs of vertices and faces and
// of edges are those of Wang et al., "A large-scale benchmark and an inclusion-based algorithm for
// continuous collision detection" (ACM Transactions on Graphics 40(5), 2021). Threads: any.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "library/deforming/mesh_sequence.h"
#include "library/detectors/detector.h"

namespace cdb::deforming {

enum class Primitives {
  kTriangles,   ///< any two triangles, in each frame
  kVertexFace,  ///< a vertex and a triangle, over each step
  kEdgeEdge,    ///< two edges, over each step
};

/// Its word on the command line and in files: `triangles`, `vertex_face`, `edge_edge`.
std::string_view WordOf(Primitives primitives);
std::optional<Primitives> PrimitivesOf(std::string_view word);
/// `triangles, vertex_face, edge_edge`
std::string PrimitiveWords();

/// True if a body moves from a frame to the next within a cycle.
constexpr bool IsSwept(Primitives primitives) { return primitives != Primitives::kTriangles; }

/// The vertices of a body; those that a vertex or an edge does not have are kNoCorner.
using Corners = std::array<std::uint32_t, 3>;
inline constexpr std::uint32_t kNoCorner = 0xffff'ffff;
constexpr std::size_t CountOf(const Corners& corners) {
  return corners[1] == kNoCorner ? 1 : corners[2] == kNoCorner ? 2 : 3;
}
/// True if the two share a vertex.
constexpr bool AreNeighbours(const Corners& a, const Corners& b) {
  for (const std::uint32_t corner : a)
    if (corner != kNoCorner && (corner == b[0] || corner == b[1] || corner == b[2])) return true;
  return false;
}

/// The bodies, in this order: triangles in that of the mesh; vertices, then triangles; edges by
/// their lower vertex, then the upper one.
std::vector<Corners> BodiesOf(Primitives primitives, const MeshSequence& sequence);
/// A vertex meets faces only, and a face vertices.
Filter FilterOf(Primitives primitives, const Corners& corners);

/// The cycles: a frame each, or a step each. Throws SceneError, if there is only one frame for a
/// step.
std::size_t CyclesOf(Primitives primitives, const MeshSequence& sequence);
/// Lower x y z and upper x y z of each body in a cycle. No side is rounded.
void FillBoxes(Primitives primitives, const MeshSequence& sequence, std::span<const Corners> bodies,
               std::size_t cycle, std::vector<double>& sides);

/// The positions of all vertices.
using Vertices = std::span<const Eigen::Vector3d>;
/// True if two bodies meet: triangles at `from`; others at some time of the step to `to`, in which
/// each vertex moves along a line. Exact; touching counts (library/exact/collision.h). The bodies
/// must be a pair of these primitives.
bool Meet(Primitives primitives, const Corners& a, const Corners& b, Vertices from, Vertices to);

}  // namespace cdb::deforming
