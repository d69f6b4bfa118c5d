#include "library/deforming/primitives.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "library/exact/collision.h"
#include "library/scene_error.h"

namespace cdb::deforming {
namespace {

constexpr std::string_view kWords[] = {"triangles", "vertex_face", "edge_edge"};

/// A box for each vertex: lower x y z, upper x y z.
std::vector<std::array<double, 6>> VertexBoxes(const MeshSequence& sequence, std::size_t from,
                                               std::size_t to) {
  std::vector<std::array<double, 6>> boxes(sequence.vertices());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Eigen::Vector3d &a = sequence.frames[from][i], &b = sequence.frames[to][i];
    for (int k = 0; k < 3; ++k) {
      const auto side = static_cast<std::size_t>(k);
      boxes[i][side] = std::min(a[k], b[k]);
      boxes[i][side + 3] = std::max(a[k], b[k]);
    }
  }
  return boxes;
}

std::vector<Corners> EdgesOf(const MeshSequence& sequence) {
  std::vector<Corners> edges;
  edges.reserve(3 * sequence.triangles.size());
  for (const auto& [a, b, c] : sequence.triangles)
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
      edges.push_back({std::min(from, to), std::max(from, to), kNoCorner});
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

std::string_view WordOf(Primitives primitives) {
  return kWords[static_cast<std::size_t>(primitives)];
}

std::optional<Primitives> PrimitivesOf(std::string_view word) {
  const auto* found = std::ranges::find(kWords, word);
  if (found == std::end(kWords)) return std::nullopt;
  return static_cast<Primitives>(found - std::begin(kWords));
}

std::string PrimitiveWords() { return fmt::format("{}", fmt::join(kWords, ", ")); }

std::vector<Corners> BodiesOf(Primitives primitives, const MeshSequence& sequence) {
  if (primitives == Primitives::kEdgeEdge) return EdgesOf(sequence);
  std::vector<Corners> bodies;
  if (primitives == Primitives::kVertexFace)
    for (std::size_t i = 0; i < sequence.vertices(); ++i)
      bodies.push_back({static_cast<std::uint32_t>(i), kNoCorner, kNoCorner});
  bodies.insert(bodies.end(), sequence.triangles.begin(), sequence.triangles.end());
  return bodies;
}

Filter FilterOf(Primitives primitives, const Corners& corners) {
  if (primitives != Primitives::kVertexFace) return {};
  constexpr std::uint32_t kVertex = 1, kFace = 2;
  return CountOf(corners) == 1 ? Filter{kVertex, kFace} : Filter{kFace, kVertex};
}

std::size_t CyclesOf(Primitives primitives, const MeshSequence& sequence) {
  if (!IsSwept(primitives)) return sequence.frames.size();
  if (sequence.frames.size() < 2)
    throw library::SceneError(
        fmt::format("a step of `{}` leads from one frame to the next, and there is one frame; name "
                    "at least two, or use `{}`",
                    WordOf(primitives), WordOf(Primitives::kTriangles)));
  return sequence.frames.size() - 1;
}

void FillBoxes(Primitives primitives, const MeshSequence& sequence, std::span<const Corners> bodies,
               std::size_t cycle, std::vector<double>& sides) {
  const auto vertices = VertexBoxes(sequence, cycle, IsSwept(primitives) ? cycle + 1 : cycle);
  sides.clear();
  sides.reserve(6 * bodies.size());
  for (const Corners& corners : bodies) {
    std::array<double, 6> box = vertices[corners[0]];
    for (std::size_t i = 1; i < CountOf(corners); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        box[k] = std::min(box[k], vertices[corners[i]][k]);
        box[k + 3] = std::max(box[k + 3], vertices[corners[i]][k + 3]);
      }
    sides.insert(sides.end(), box.begin(), box.end());
  }
}

bool Meet(Primitives primitives, const Corners& a, const Corners& b, Vertices from, Vertices to) {
  if (primitives == Primitives::kTriangles) {
    const auto triangle = [&](const Corners& corners) {
      return std::array{from[corners[0]], from[corners[1]], from[corners[2]]};
    };
    return exact::TrianglesMeet(triangle(a), triangle(b));
  }
  const bool is_a_first = CountOf(a) <= CountOf(b);  // the vertex, of a vertex and a face
  const Corners &first = is_a_first ? a : b, &second = is_a_first ? b : a;
  exact::MovingPoints points;
  std::size_t count = 0;
  for (const Corners* corners : {&first, &second})
    for (std::size_t i = 0; i < CountOf(*corners); ++i, ++count) {
      points.from[count] = from[(*corners)[i]];
      points.to[count] = to[(*corners)[i]];
    }
  return primitives == Primitives::kVertexFace ? exact::VertexMeetsFace(points)
                                               : exact::EdgesMeet(points);
}

}  // namespace cdb::deforming
