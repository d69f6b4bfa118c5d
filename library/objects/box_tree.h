// A bounding volume hierarchy over static boxes.
//
// Built once by splitting at the median of the longest axis. A query visits the boxes that overlap
// another one, in an order that depends only on the boxes. O(n log^2 n) to build, O(log n) for each
// box found. Threads: any, once built. Source: Ericson, Real-Time Collision Detection, 2005,
// section 6.2.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace cdb::objects {

class BoxTree {
 public:
  explicit BoxTree(std::vector<Eigen::AlignedBox3d> boxes);

  std::size_t size() const { return boxes_.size(); }
  /// Calls `visit(index)` for boxes that overlap or touch `box`, until it returns true; returns
  /// whether it did.
  template <typename Visit>
  bool AnyOf(const Eigen::AlignedBox3d& box, Visit visit) const {
    return !nodes_.empty() && AnyBelow(0, box, visit);
  }

 private:
  static constexpr std::uint32_t kLeafSize = 4;
  /// A leaf contains order_ in [first, end); the children of an inner node are the next node and
  /// `second`.
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first, end, second;
  };

  std::uint32_t Build(std::uint32_t first, std::uint32_t end);

  template <typename Visit>
  bool AnyBelow(std::uint32_t index, const Eigen::AlignedBox3d& box, Visit& visit) const {
    const Node& node = nodes_[index];
    if (!node.box.intersects(box)) return false;
    if (node.second != 0)
      return AnyBelow(index + 1, box, visit) || AnyBelow(node.second, box, visit);
    for (std::uint32_t i = node.first; i < node.end; ++i)
      if (boxes_[order_[i]].intersects(box) && visit(std::size_t{order_[i]})) return true;
    return false;
  }

  std::vector<Eigen::AlignedBox3d> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace cdb::objects
