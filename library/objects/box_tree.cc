#include "library/objects/box_tree.h"

#include <algorithm>
#include <numeric>

namespace cdb::objects {

BoxTree::BoxTree(std::vector<Eigen::AlignedBox3d> boxes) : boxes_(std::move(boxes)) {
  order_.resize(boxes_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.reserve(boxes_.size());
  if (!boxes_.empty()) Build(0, static_cast<std::uint32_t>(boxes_.size()));
}

std::uint32_t BoxTree::Build(std::uint32_t first, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, first, end, 0});
  for (std::uint32_t i = first; i < end; ++i) nodes_[index].box.extend(boxes_[order_[i]]);
  if (end - first <= kLeafSize) return index;
  int axis = 0;
  nodes_[index].box.sizes().maxCoeff(&axis);
  const std::uint32_t middle = first + (end - first) / 2;
  // Equal middles are ordered by their index, so that the order is always the same.
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double of_a = boxes_[a].center()[axis], of_b = boxes_[b].center()[axis];
                     return of_a != of_b ? of_a < of_b : a < b;
                   });
  Build(first, middle);
  const std::uint32_t second = Build(middle, end);
  nodes_[index].second = second;
  return index;
}

}  // namespace cdb::objects
