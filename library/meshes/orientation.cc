#include "library/meshes/orientation.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

/// Sets of faces, each face turned or not relative to its set.
class FaceSets {
 public:
  explicit FaceSets(std::size_t faces) : parent_(faces), is_turned_(faces, false) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  struct Place {
    std::uint32_t set;
    bool is_turned;
  };
  Place Find(std::uint32_t face) {
    std::uint32_t root = face;
    bool is_turned = false;
    for (; parent_[root] != root; root = parent_[root]) is_turned ^= is_turned_[root];
    const Place found{root, is_turned};
    while (parent_[face] != root && face != root) {
      const std::uint32_t next = parent_[face];
      const bool next_is_turned = is_turned ^ is_turned_[face];
      parent_[face] = root;
      is_turned_[face] = is_turned;
      face = next;
      is_turned = next_is_turned;
    }
    return found;
  }
  /// False if the faces are in one set already, in which they are the other way round.
  bool Join(std::uint32_t a, std::uint32_t b, bool is_turned) {
    const Place of_a = Find(a), of_b = Find(b);
    const bool between = of_a.is_turned ^ of_b.is_turned ^ is_turned;
    if (of_a.set == of_b.set) return !between;
    // The first face of a set represents it.
    const auto [low, high] = std::minmax(of_a.set, of_b.set);
    parent_[high] = low;
    is_turned_[high] = between;
    return true;
  }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<bool> is_turned_;  ///< relative to the parent
};

bool IsBalanced(std::span<const FaceEdge> edge) {
  return 2 * static_cast<std::size_t>(std::ranges::count(edge, true, &FaceEdge::rises)) ==
         edge.size();
}

/// The faces at an edge, by their angle about it.
std::vector<FaceEdge> ByAngle(const Mesh& mesh, std::span<const FaceEdge> edge) {
  if (edge.size() == 2) return {edge.begin(), edge.end()};
  const Vector3d& low = mesh.vertices[edge[0].low];
  const Vector3d along = (mesh.vertices[edge[0].high] - low).normalized();
  const Vector3d u = along.unitOrthogonal(), v = along.cross(u);
  std::vector<std::pair<double, FaceEdge>> faces;
  for (const FaceEdge& face : edge) {
    const Triangle& t = mesh.triangles[face.face];
    const Vector3d across = mesh.vertices[t[0] ^ t[1] ^ t[2] ^ face.low ^ face.high] - low;
    faces.emplace_back(std::atan2(v.dot(across), u.dot(across)), face);
  }
  std::ranges::stable_sort(faces, {}, [](const auto& face) { return face.first; });
  std::vector<FaceEdge> sorted;
  for (const auto& [angle, face] : faces) sorted.push_back(face);
  return sorted;
}

void Turn(Triangle& t) { std::swap(t[1], t[2]); }

struct Shell {
  std::vector<std::uint32_t> faces;
  Eigen::AlignedBox3d box;
  double volume = 0;
  bool disagreed = false;
};

double VolumeOf(const Mesh& mesh, const Triangle& triangle, const Vector3d& origin) {
  const auto [a, b, c] = CornersOf(mesh, triangle);
  return (a - origin).dot((b - origin).cross(c - origin)) / 6;
}

/// Calls `visit` with the faces that each shell has at each edge.
template <typename Visit>
void ForEachEdgeOfShell(std::span<const FaceEdge> edges, FaceSets& shells, const Visit& visit) {
  const auto shell = [&](const FaceEdge& face) { return shells.Find(face.face).set; };
  std::vector<FaceEdge> sorted;
  ForEachEdge(edges, [&](std::span<const FaceEdge> edge) {
    sorted.assign(edge.begin(), edge.end());
    std::ranges::stable_sort(sorted, {}, shell);
    for (std::size_t begin = 0, end; begin < sorted.size(); begin = end) {
      for (end = begin; end < sorted.size() && shell(sorted[end]) == shell(sorted[begin]);) ++end;
      visit(std::span<const FaceEdge>(sorted).subspan(begin, end - begin));
    }
  });
}

/// The faces that share edges of two faces, and the sets of these that are closed only together.
FaceSets ShellsOf(const Mesh& mesh, std::span<const FaceEdge> edges) {
  FaceSets shells(mesh.triangles.size());
  ForEachEdge(edges, [&](std::span<const FaceEdge> edge) {
    if (edge.size() == 2) shells.Join(edge[0].face, edge[1].face, false);
  });
  std::vector<std::uint32_t> odd;
  ForEachEdge(edges, [&](std::span<const FaceEdge> edge) {
    if (edge.size() == 2) return;
    odd.clear();
    ForEachEdgeOfShell(edge, shells, [&](std::span<const FaceEdge> faces) {
      if (faces.size() % 2 != 0) odd.push_back(faces[0].face);
    });
    for (const std::uint32_t face : odd) shells.Join(odd[0], face, false);
  });
  return shells;
}

/// Makes the faces of each shell agree.
std::vector<Shell> AgreeingShells(Mesh& mesh, std::string_view name) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  const std::vector<FaceEdge> edges = SortedEdges(mesh);
  FaceSets connected = ShellsOf(mesh, edges);
  std::vector<bool> disagrees(count, false);
  ForEachEdgeOfShell(edges, connected, [&](std::span<const FaceEdge> edge) {
    if (!IsBalanced(edge)) disagrees[connected.Find(edge[0].face).set] = true;
  });
  FaceSets sides(count);
  ForEachEdgeOfShell(edges, connected, [&](std::span<const FaceEdge> edge) {
    if (!disagrees[connected.Find(edge[0].face).set]) return;
    const std::vector<FaceEdge> sorted = ByAngle(mesh, edge);
    for (std::size_t i = 1; i < sorted.size(); ++i)
      if (!sides.Join(sorted[i - 1].face, sorted[i].face, sorted[i - 1].rises == sorted[i].rises))
        throw library::SceneError(
            fmt::format("{}: has no inside: its faces cannot be made to agree, as on a Moebius "
                        "strip, at the edge from {}",
                        name, Written(mesh, edge[0])));
  });
  std::vector<Shell> shells;
  std::vector<std::uint32_t> number(count, count);
  for (std::uint32_t face = 0; face < count; ++face) {
    const std::uint32_t set = connected.Find(face).set;
    if (number[set] == count) {
      number[set] = static_cast<std::uint32_t>(shells.size());
      shells.emplace_back().disagreed = disagrees[set];
    }
    Shell& shell = shells[number[set]];
    shell.faces.push_back(face);
    for (const Vector3d& corner : CornersOf(mesh, mesh.triangles[face])) shell.box.extend(corner);
    if (disagrees[set] && sides.Find(face).is_turned) Turn(mesh.triangles[face]);
  }
  for (Shell& shell : shells)
    for (const std::uint32_t face : shell.faces)
      shell.volume += VolumeOf(mesh, mesh.triangles[face], shell.box.center());
  return shells;
}

/// How often a shell goes round a point, along a ray in the direction of x. A ray that meets an
/// edge is on the same side of it for all of its faces.
int WindingAbout(const Mesh& mesh, const Shell& shell, const Vector3d& point) {
  if (!shell.box.contains(point)) return 0;
  const auto side = [&](std::uint32_t from, std::uint32_t to) {
    const Vector3d low = mesh.vertices[std::min(from, to)] - point;
    const Vector3d high = mesh.vertices[std::max(from, to)] - point;
    return (low.y() * high.z() - low.z() * high.y() >= 0) == (from < to);
  };
  int winding = 0;
  for (const std::uint32_t face : shell.faces) {
    const Triangle& t = mesh.triangles[face];
    const bool is_left = side(t[0], t[1]);
    if (side(t[1], t[2]) != is_left || side(t[2], t[0]) != is_left) continue;
    const auto [a, b, c] = CornersOf(mesh, t);
    const Vector3d normal = (b - a).cross(c - a);
    if (normal.dot(a - point) * normal.x() > 0) winding += is_left ? 1 : -1;
  }
  return winding;
}

/// How often `outer` goes round `inner`: the median of three faces of it, as it may touch.
int WindingAbout(const Mesh& mesh, const Shell& outer, const Shell& inner) {
  if (!outer.box.contains(inner.box)) return 0;
  std::array<int, 3> windings{};
  const std::size_t last = inner.faces.size() - 1;
  for (std::size_t i = 0; i < 3; ++i) {
    Triangle t = mesh.triangles[inner.faces[i * last / 2]];
    std::ranges::sort(t);  // rounds in the same way if it is turned
    const auto [a, b, c] = CornersOf(mesh, t);
    windings[i] = WindingAbout(mesh, outer, (a + b + c) / 3);
  }
  std::ranges::sort(windings);
  return windings[1];
}

void TurnShell(Mesh& mesh, Shell& shell) {
  for (const std::uint32_t face : shell.faces) Turn(mesh.triangles[face]);
  shell.volume = -shell.volume;
}

}  // namespace

std::vector<FaceEdge> SortedEdges(const Mesh& mesh) {
  std::vector<FaceEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
    for (std::size_t i = 0; i < 3; ++i) {
      const Triangle& t = mesh.triangles[face];
      const std::uint32_t from = t[i], to = t[(i + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), face, from < to});
    }
  std::ranges::sort(edges, [](const FaceEdge& a, const FaceEdge& b) {
    return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
  });
  return edges;
}

std::string Written(const Vector3d& p) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z());
}

std::string Written(const Mesh& mesh, const FaceEdge& edge) {
  return fmt::format("{} to {}", Written(mesh.vertices[edge.low]),
                     Written(mesh.vertices[edge.high]));
}

void Orient(Mesh& mesh, std::string_view name) {
  std::vector<Shell> shells = AgreeingShells(mesh, name);
  std::ranges::stable_sort(shells, std::ranges::greater(),
                           [](const Shell& shell) { return std::abs(shell.volume); });
  for (std::size_t i = 0; i < shells.size(); ++i) {
    Shell& shell = shells[i];
    if (!shell.disagreed && shell.volume >= 0) continue;
    int winding = 0;
    for (std::size_t k = 0; k < i; ++k) winding += WindingAbout(mesh, shells[k], shell);
    const bool should_be_cavity = winding >= 1;
    if (should_be_cavity == (shell.volume < 0)) continue;
    // Those within it keep their place in it, unless they are to be placed themselves.
    if (!shell.disagreed)
      for (std::size_t k = i + 1; k < shells.size(); ++k)
        if (!shells[k].disagreed && WindingAbout(mesh, shell, shells[k]) != 0)
          TurnShell(mesh, shells[k]);
    TurnShell(mesh, shell);
  }
}

}  // namespace cdb::meshes
