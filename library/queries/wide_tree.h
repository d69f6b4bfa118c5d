// A bounding volume hierarchy of boxes in single precision, with four children a node, whose boxes
// are tested at once.
//
// Boxes contain what they stand for, so that no hit is missed; a query calls back for each box that
// it meets, the nearest first. Split at the median of the longest axis. Building takes O(n log n),
// refitting O(n). Threads: queries any, once built. Sources: Wald, Benthin, Boulos, "Getting rid of
// packets", IEEE Symposium on Interactive Ray Tracing, 2008; slabs with rounding as in Ize, "Robust
// BVH Ray Traversal", Journal of Computer Graphics Techniques 2(2), 2013.
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace cdb::queries {

struct FloatBox {
  std::array<float, 3> lower, upper;
};

/// The least box in single precision that contains the other, and a margin of a rounding.
FloatBox BoxAround(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper);

class WideTree {
 public:
  /// A ray as the boxes see it: the points from + t along, 0 <= t <= limit.
  class Ray {
   public:
    /// `half`: half extents of a box that moves along, with its middle on the ray.
    Ray(const Eigen::Vector3d& from, const Eigen::Vector3d& along, double limit,
        const Eigen::Vector3d& half = Eigen::Vector3d::Zero());

   private:
    friend class WideTree;
    std::array<float, 3> from_, inverse_, slack_;
    std::array<int, 3> near_;  ///< of the two bounds along each axis, 1 if the ray comes from above
  };

  void Build(std::span<const FloatBox> boxes);
  /// The boxes have moved, and are as many as before.
  void Refit(std::span<const FloatBox> boxes);
  /// The sum of the surfaces of all boxes of nodes, as a measure of the time of a query.
  double Cost() const;
  bool IsEmpty() const { return nodes_.empty(); }

  /// Calls `visit(index)` for boxes that the ray meets before `limit`, which the call may reduce;
  /// ends when one returns true.
  template <typename Visit>
  void ForRay(const Ray& ray, const float& limit, Visit visit) const;
  /// The same for boxes that are at most `limit` away from `box`; those that overlap it are 0 away.
  template <typename Visit>
  void ForNear(const FloatBox& box, const float& limit, Visit visit) const;

 private:
  static constexpr std::size_t kWidth = 4;
  typedef float Lanes __attribute__((vector_size(16)));
  static constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();

  struct alignas(16) Node {
    std::array<std::array<float, kWidth>, 3> bounds[2];  ///< lower, upper; by axis and child
    std::array<std::int32_t, kWidth> children;           ///< ~index of a box, a node, or kNone
  };

  std::int32_t BuildNode(std::span<const FloatBox> boxes, std::span<std::uint32_t> part);
  static void SetBox(Node& node, std::size_t child, const FloatBox& box);
  static FloatBox BoxOf(const Node& node);
  static Lanes Load(const float* four) { return *reinterpret_cast<const Lanes*>(four); }
  /// Visits nodes and boxes, the nearest first. `measure(node, at)` gives a mask of the children
  /// that count, and how near they are; `is_beyond(at)`: whether that is too far by now.
  template <typename Measure, typename IsBeyond, typename Visit>
  void Walk(Measure measure, IsBeyond is_beyond, Visit visit) const;

  std::vector<Node> nodes_;  ///< children after their parent
  std::vector<std::uint32_t> order_;
};

template <typename Measure, typename IsBeyond, typename Visit>
void WideTree::Walk(Measure measure, IsBeyond is_beyond, Visit visit) const {
  if (nodes_.empty()) return;
  struct Entry {
    std::int32_t child;
    float at;
  };
  // A node leaves at most three of its children on the stack, and a tree of 2^31 boxes has at most
  // 16 levels.
  std::array<Entry, 64> stack;
  std::size_t height = 0;
  stack[height++] = {0, 0};
  while (height > 0) {
    const Entry entry = stack[--height];
    if (is_beyond(entry.at)) continue;
    if (entry.child < 0) {
      if (visit(static_cast<std::size_t>(~entry.child))) return;
      continue;
    }
    const Node& node = nodes_[static_cast<std::size_t>(entry.child)];
    Lanes at;
    const auto counts = measure(node, at);
    Entry found[kWidth];
    std::size_t count = 0;
    for (std::size_t child = 0; child < kWidth; ++child)
      if (counts[child] && node.children[child] != kNone) {
        const Entry next = {node.children[child], at[child]};
        std::size_t place = count++;
        for (; place > 0 && found[place - 1].at < next.at; --place) found[place] = found[place - 1];
        found[place] = next;
      }
    for (std::size_t i = 0; i < count; ++i) stack[height++] = found[i];
  }
}

template <typename Visit>
void WideTree::ForRay(const Ray& ray, const float& limit, Visit visit) const {
  constexpr float kDown = 1 - 8 * std::numeric_limits<float>::epsilon(),
                  kUp = 1 + 8 * std::numeric_limits<float>::epsilon();
  const auto measure = [&](const Node& node, Lanes& at) {
    Lanes near = {0, 0, 0, 0}, far = {limit, limit, limit, limit};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto side = static_cast<std::size_t>(ray.near_[axis]);
      const float slack = side == 0 ? ray.slack_[axis] : -ray.slack_[axis];
      const Lanes first =
          (Load(node.bounds[side][axis].data()) - (ray.from_[axis] + slack)) * ray.inverse_[axis];
      const Lanes last = (Load(node.bounds[1 - side][axis].data()) - (ray.from_[axis] - slack)) *
                         ray.inverse_[axis];
      near = first > near ? first : near;
      far = last < far ? last : far;
    }
    at = near * kDown;
    return at <= far * kUp;
  };
  Walk(
      measure, [&](float at) { return at > limit; }, visit);
}

template <typename Visit>
void WideTree::ForNear(const FloatBox& box, const float& limit, Visit visit) const {
  // Squares of distances; less by what rounding may add.
  constexpr float kDown = 1 - 16 * std::numeric_limits<float>::epsilon();
  const auto is_beyond = [&](float square) { return square * kDown > limit * limit; };
  const auto measure = [&](const Node& node, Lanes& at) {
    at = Lanes{0, 0, 0, 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Lanes zero = {0, 0, 0, 0};
      const Lanes below = Load(node.bounds[0][axis].data()) - box.upper[axis],
                  above = box.lower[axis] - Load(node.bounds[1][axis].data());
      Lanes gap = below > above ? below : above;
      gap = gap > zero ? gap : zero;
      at += gap * gap;
    }
    const float most = limit * limit;
    return at * kDown <= Lanes{most, most, most, most};
  };
  Walk(measure, is_beyond, visit);
}

}  // namespace cdb::queries
