#include "library/meshes/topology.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include "library/meshes/mass_properties.h"
#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

constexpr std::uint32_t kNone = 0xffffffff;

struct Edge {
  std::uint32_t low, high;
  bool rises;  ///< runs from low to high
  bool SameAs(const Edge& other) const { return low == other.low && high == other.high; }
};

std::vector<Edge> SortedEdges(const Mesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i], to = t[(i + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.rises) < std::tie(b.low, b.high, b.rises);
  });
  return edges;
}

struct EdgeFaults {
  std::size_t open = 0, crowded = 0, against = 0;
  std::optional<Edge> first_open, first_crowded, first_against;
};

EdgeFaults FaultsOf(const Mesh& mesh) {
  EdgeFaults faults;
  const std::vector<Edge> edges = SortedEdges(mesh);
  for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
    std::size_t rising = 0;
    for (end = begin; end < edges.size() && edges[end].SameAs(edges[begin]); ++end)
      rising += edges[end].rises ? 1 : 0;
    const auto note = [&](std::size_t& count, std::optional<Edge>& first) {
      if (count++ == 0) first = edges[begin];
    };
    if (end - begin == 1)
      note(faults.open, faults.first_open);
    else if (end - begin > 2)
      note(faults.crowded, faults.first_crowded);
    else if (rising != 1)
      note(faults.against, faults.first_against);
  }
  return faults;
}

std::string Written(const Vector3d& p) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z());
}

std::string Written(const Mesh& mesh, const Edge& edge) {
  return fmt::format("{} to {}", Written(mesh.vertices[edge.low]),
                     Written(mesh.vertices[edge.high]));
}

std::string Edges(std::size_t count) {
  return count == 1 ? "1 edge" : fmt::format("{} edges", count);
}

[[noreturn]] void Refuse(std::string_view name, std::string_view what) {
  throw library::SceneError(fmt::format("{}: {}", name, what));
}

Mesh WithoutUnusedVertices(const Mesh& mesh) {
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
  Mesh used;
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t vertex : t) number[vertex] = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] == kNone) continue;
    number[i] = static_cast<std::uint32_t>(used.vertices.size());
    used.vertices.push_back(mesh.vertices[i]);
  }
  for (const Triangle& t : mesh.triangles)
    used.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  return used;
}

void TurnRound(Mesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

/// Checks that each part has a volume, or is a cavity in one that has.
void CheckParts(const Mesh& mesh, std::string_view name) {
  const std::vector<std::uint32_t> part_of = PartsOf(mesh);
  std::vector<Mesh> parts(1 + *std::max_element(part_of.begin(), part_of.end()));
  if (parts.size() == 1) return;
  std::vector<Eigen::AlignedBox3d> boxes(parts.size());
  std::vector<double> volumes(parts.size(), 0);
  const Vector3d origin = mesh.vertices[0];
  for (std::size_t i = 0; i < part_of.size(); ++i) {
    const auto [a, b, c] = CornersOf(mesh, mesh.triangles[i]);
    boxes[part_of[i]].extend(a).extend(b).extend(c);
    volumes[part_of[i]] += (a - origin).dot((b - origin).cross(c - origin)) / 6;
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (volumes[i] >= 0) continue;
    bool is_cavity = false;
    for (std::size_t k = 0; k < parts.size() && !is_cavity; ++k)
      is_cavity = volumes[k] > -volumes[i] && boxes[k].contains(boxes[i]);
    if (!is_cavity)
      Refuse(name, fmt::format("the part from {} to {} is inside out, but not a cavity of another "
                               "part; flip its faces",
                               Written(boxes[i].min()), Written(boxes[i].max())));
  }
}

}  // namespace

std::vector<std::uint32_t> PartsOf(const Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t vertex) {
    while (parent[vertex] != vertex) vertex = parent[vertex] = parent[parent[vertex]];
    return vertex;
  };
  for (const Triangle& t : mesh.triangles) {
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone), parts;
  std::uint32_t count = 0;
  for (const Triangle& t : mesh.triangles) {
    std::uint32_t& part = number[root(t[0])];
    if (part == kNone) part = count++;
    parts.push_back(part);
  }
  return parts;
}

Mesh Watertight(Mesh mesh, std::string_view name) {
  if (mesh.triangles.empty()) Refuse(name, "has no faces; a model needs a closed surface");
  std::size_t degenerate = 0, first = 0;
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) {
    const Triangle& t = mesh.triangles[i];
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) continue;
    ++degenerate;
    first = i;
  }
  if (degenerate > 0)
    Refuse(name, fmt::format("{} of {} triangles have a vertex twice, the first at {}; remove "
                             "degenerate faces",
                             degenerate, mesh.triangles.size(),
                             Written(mesh.vertices[mesh.triangles[first][0]])));
  EdgeFaults faults = FaultsOf(mesh);
  if (faults.open > 0) {
    Mesh merged = MergeEqualVertices(mesh);
    const EdgeFaults after = FaultsOf(merged);
    // Merging may also join parts that only touch, so it is used only if it does no harm.
    if (after.open < faults.open && after.crowded == 0 && after.against == 0) {
      mesh = std::move(merged);
      faults = after;
    }
  }
  if (faults.open > 0)
    Refuse(name, fmt::format("is not watertight: {} of one face only, the first from {}; close the "
                             "holes in a modelling program",
                             Edges(faults.open), Written(mesh, *faults.first_open)));
  if (faults.crowded > 0)
    Refuse(name, fmt::format("{} of more than two faces, the first from {}; a solid's surface has "
                             "two at each",
                             Edges(faults.crowded), Written(mesh, *faults.first_crowded)));
  if (faults.against > 0)
    Refuse(name, fmt::format("{} where the two faces are oriented inconsistently, the first from "
                             "{}; make the normals consistent",
                             Edges(faults.against), Written(mesh, *faults.first_against)));
  mesh = WithoutUnusedVertices(mesh);
  double volume = SignedVolume(mesh);
  if (volume < 0) {
    TurnRound(mesh);
    volume = -volume;
  }
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  // Rounding leaves some volume in a mesh that has none.
  if (!(volume > 1e-12 * std::pow(box.diagonal().norm(), 3)))
    Refuse(name, "has no volume; a flat or folded surface is not a solid");
  CheckParts(mesh, name);
  return mesh;
}

Mesh CloseHoles(const Mesh& open, std::string_view name) {
  Mesh mesh = MergeEqualVertices(open);
  std::vector<std::uint32_t> next(mesh.vertices.size(), kNone);
  const std::vector<Edge> edges = SortedEdges(mesh);
  for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
    for (end = begin; end < edges.size() && edges[end].SameAs(edges[begin]);) ++end;
    if (end - begin != 1) continue;
    // The cap has this edge in the opposite direction.
    const std::uint32_t from = edges[begin].rises ? edges[begin].high : edges[begin].low;
    const std::uint32_t to = edges[begin].rises ? edges[begin].low : edges[begin].high;
    if (next[from] != kNone)
      Refuse(name, fmt::format("holes touch at {}; close them in a modelling program",
                               Written(mesh.vertices[from])));
    next[from] = to;
  }
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
