#include "library/meshes/topology.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "library/meshes/convex_hull.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/orientation.h"
#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

constexpr std::uint32_t kNone = 0xffffffff;

/// Vertices are welded within this fraction of the size: exporters round in single precision, and
/// some print fewer digits, but a gap that is wider may be intended.
constexpr double kWeld = 1e-8;

struct OddEdges {
  std::size_t open = 0, crowded = 0;  ///< of one face; of 3, 5 and so on
  std::optional<FaceEdge> first_open, first_crowded;
  std::vector<std::uint32_t> vertices;  ///< of all of them
};

OddEdges OddEdgesOf(const Mesh& mesh) {
  OddEdges odd;
  ForEachEdge(SortedEdges(mesh), [&](std::span<const FaceEdge> edge) {
    if (edge.size() % 2 == 0) return;
    odd.vertices.insert(odd.vertices.end(), {edge[0].low, edge[0].high});
    auto& first = edge.size() == 1 ? odd.first_open : odd.first_crowded;
    if (!first) first = edge[0];
    ++(edge.size() == 1 ? odd.open : odd.crowded);
  });
  return odd;
}

std::string Edges(std::size_t count) {
  return count == 1 ? "1 edge" : fmt::format("{} edges", count);
}

[[noreturn]] void Refuse(std::string_view name, std::string_view what) {
  throw library::SceneError(fmt::format("{}: {}", name, what));
}

/// What to do with a mesh that is no solid.
std::string TypesThatTake(const Mesh& mesh) {
  const char* what = TryConvexHull(mesh.vertices)
                         ? mesh.triangles.empty() ? "hull takes" : "hull and surface take"
                     : mesh.triangles.empty() ? "no type takes"
                                              : "surface takes";
  return fmt::format("{} it as it is", what);
}

/// Without triangles that have a vertex twice, without those that are there twice, and without
/// vertices of none. Of two equal triangles the first stays, even if the other is turned round and
/// `both_sides` is false.
Mesh Tidy(Mesh mesh, bool both_sides = true) {
  std::erase_if(mesh.triangles,
                [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  const auto key = [&](std::uint32_t face) {
    Triangle t = mesh.triangles[face];
    if (both_sides)
      std::ranges::rotate(t, std::ranges::min_element(t));
    else
      std::ranges::sort(t);
    return t;
  };
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, key);
  std::vector<bool> is_double(order.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i)
    is_double[order[i]] = key(order[i]) == key(order[i - 1]);
  std::size_t face = 0;
  std::erase_if(mesh.triangles, [&](const Triangle&) { return is_double[face++]; });
  return SubMesh(mesh, mesh.triangles);
}

/// Without triangles that are there an even number of times, whichever way round, and with one of
/// those that are there an odd number of times. The number of faces at each edge stays even, or
/// odd.
Mesh WithoutPairs(Mesh mesh) {
  std::map<Triangle, std::size_t> copies;
  const auto key = [](Triangle t) {
    std::ranges::sort(t);
    return t;
  };
  for (const Triangle& t : mesh.triangles) ++copies[key(t)];
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    std::size_t& left = copies[key(t)];
    const bool stays = left % 2 == 1;
    left = 0;
    return !stays;
  });
  return mesh;
}

double LongestSide(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return mesh.vertices.empty() ? 0 : box.sizes().maxCoeff();
}

/// The mesh, tidied, with vertices merged as far as needed to close it; equal ones, or else also
/// close ones.
Mesh Closed(const Mesh& raw, std::string_view name) {
  Mesh mesh = Tidy(raw);
  OddEdges odd = OddEdgesOf(mesh);
  // Merging may also join parts that only touch, so a closed mesh stays as it is.
  if (!odd.vertices.empty()) {
    mesh = Tidy(MergeEqualVertices(mesh));
    odd = OddEdgesOf(mesh);
  }
  if (!odd.vertices.empty())
    // A flap, folded from two equal triangles, closes a mesh and bounds nothing.
    if (Mesh flat = Tidy(WithoutPairs(MergeEqualVertices(raw))); OddEdgesOf(flat).vertices.empty())
      return flat;
  if (!odd.vertices.empty()) {
    Mesh welded = Tidy(MergeCloseVertices(mesh, odd.vertices, kWeld * LongestSide(mesh)));
    OddEdges after = OddEdgesOf(welded);
    if (after.vertices.size() < odd.vertices.size()) {
      mesh = std::move(welded);
      odd = std::move(after);
    }
  }
  if (odd.open > 0)
    Refuse(name,
           fmt::format("is not watertight: {} of one face only, the first from {}; close the holes "
                       "in a modelling program; {}",
                       Edges(odd.open), Written(mesh, *odd.first_open), TypesThatTake(mesh)));
  if (odd.crowded > 0)
    Refuse(name,
           fmt::format("{} of an odd number of faces, the first from {}; a solid's surface has an "
                       "even number at each; {}",
                       Edges(odd.crowded), Written(mesh, *odd.first_crowded), TypesThatTake(mesh)));
  return mesh;
}

/// True up to rounding, which leaves some volume in a mesh that has none.
bool HasVolume(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return !mesh.triangles.empty() && SignedVolume(mesh) > 1e-12 * std::pow(box.diagonal().norm(), 3);
}

}  // namespace

Mesh Watertight(Mesh mesh, std::string_view name) {
  if (mesh.triangles.empty())
    Refuse(name,
           fmt::format("has no faces; a solid needs a closed surface; {}", TypesThatTake(mesh)));
  mesh = Closed(mesh, name);
  Orient(mesh, name);
  if (!HasVolume(mesh)) {
    // Some exporters write each face with both sides.
    Mesh one_sided = Tidy(mesh, false);
    if (one_sided.triangles.size() < mesh.triangles.size() &&
        OddEdgesOf(one_sided).vertices.empty()) {
      mesh = std::move(one_sided);
      Orient(mesh, name);
    }
  }
  if (!HasVolume(mesh))
    Refuse(name, fmt::format("has no volume; a flat or folded surface is not a solid; {}",
                             TypesThatTake(mesh)));
  return mesh;
}

Mesh CloseHoles(const Mesh& open, std::string_view name) {
  Mesh mesh = MergeEqualVertices(open);
  std::vector<std::uint32_t> next(mesh.vertices.size(), kNone);
  ForEachEdge(SortedEdges(mesh), [&](std::span<const FaceEdge> edge) {
    if (edge.size() != 1) return;
    // The cap has this edge in the opposite direction.
    const std::uint32_t from = edge[0].rises ? edge[0].high : edge[0].low;
    const std::uint32_t to = edge[0].rises ? edge[0].low : edge[0].high;
    if (next[from] != kNone)
      Refuse(name, fmt::format("holes touch at {}; close them in a modelling program",
                               Written(mesh.vertices[from])));
    next[from] = to;
  });
  const auto count = static_cast<std::uint32_t>(next.size());
  for (std::uint32_t start = 0; start < count; ++start) {
    if (next[start] == kNone) continue;
    std::vector<std::uint32_t> loop;
    for (std::uint32_t at = start; next[at] != kNone;) {
      loop.push_back(at);
      const std::uint32_t to = next[at];
      next[at] = kNone;
      at = to;
    }
    if (loop.size() == 3) {
      mesh.triangles.push_back({loop[0], loop[1], loop[2]});
      continue;
    }
    Vector3d mean = Vector3d::Zero();
    for (const std::uint32_t vertex : loop) mean += mesh.vertices[vertex];
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(mean / static_cast<double>(loop.size()));
    for (std::size_t i = 0; i < loop.size(); ++i)
      mesh.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], middle});
  }
  return mesh;
}

}  // namespace cdb::meshes
