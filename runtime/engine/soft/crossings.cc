#include "runtime/engine/soft/crossings.h"

#include <algorithm>
#include <vector>

namespace cdb::soft {
namespace {

using Eigen::Vector3d;

/// Six times the volume of a tetrahedron; its sign is the side of the plane a, b, c on which d is.
double SideOf(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool Pierces(const Vector3d& p, const Vector3d& q, const Vector3d& a, const Vector3d& b,
             const Vector3d& c) {
  const double from = SideOf(a, b, c, p), to = SideOf(a, b, c, q);
  if (!((from < 0 && to > 0) || (from > 0 && to < 0))) return false;
  const double ab = SideOf(p, q, a, b), bc = SideOf(p, q, b, c), ca = SideOf(p, q, c, a);
  return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
}

struct Box {
  Vector3d lower, upper;
  std::size_t index;
};

template <std::size_t kCount>
Box BoxOf(const std::array<std::uint32_t, kCount>& corners, std::span<const Vector3d> nodes,
          std::size_t index) {
  Box box{nodes[corners[0]], nodes[corners[0]], index};
  for (const std::uint32_t node : corners) {
    box.lower = box.lower.cwiseMin(nodes[node]);
    box.upper = box.upper.cwiseMax(nodes[node]);
  }
  return box;
}

template <std::size_t kCount>
std::vector<Box> BoxesOf(const std::vector<std::array<std::uint32_t, kCount>>& all,
                         std::span<const Vector3d> nodes) {
  std::vector<Box> boxes;
  boxes.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) boxes.push_back(BoxOf(all[i], nodes, i));
  return boxes;
}

}  // namespace

std::size_t CountCrossings(const analysis::SoftMesh& mesh, std::span<const Vector3d> nodes) {
  if (mesh.triangles.empty()) return 0;
  std::vector<Box> triangles = BoxesOf(mesh.triangles, nodes);
  const std::vector<Box> links = BoxesOf(mesh.links, nodes);
  // Sweep and prune along the longest side of the body.
  Vector3d lower = triangles[0].lower, upper = triangles[0].upper;
  for (const Box& box : triangles) {
    lower = lower.cwiseMin(box.lower);
    upper = upper.cwiseMax(box.upper);
  }
  Eigen::Index axis = 0;
  (upper - lower).maxCoeff(&axis);
  const auto start = [axis](const Box& box) { return box.lower[axis]; };
  std::ranges::sort(triangles, {}, start);
  double longest = 0;
  for (const Box& box : triangles) longest = std::max(longest, box.upper[axis] - box.lower[axis]);
  std::size_t count = 0;
  for (const Box& link : links) {
    const auto& ends = mesh.links[link.index];
    auto at = std::ranges::lower_bound(triangles, link.lower[axis] - longest, {}, start);
    for (bool is_counted = false;
         !is_counted && at != triangles.end() && at->lower[axis] <= link.upper[axis]; ++at) {
      if ((at->lower.array() > link.upper.array()).any() ||
          (at->upper.array() < link.lower.array()).any())
        continue;
      const auto& corners = mesh.triangles[at->index];
      if (std::ranges::find_first_of(ends, corners) != ends.end()) continue;
      is_counted = Pierces(nodes[ends[0]], nodes[ends[1]], nodes[corners[0]], nodes[corners[1]],
                           nodes[corners[2]]);
      count += is_counted;
    }
  }
  return count;
}

}  // namespace cdb::soft
