#include "library/queries/wide_tree.h"

#include <algorithm>
#include <numeric>

namespace cdb::queries {
namespace {

constexpr float kEpsilon = std::numeric_limits<float>::epsilon();

/// A box that nothing meets.
constexpr FloatBox kNoBox = {
    {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
     std::numeric_limits<float>::infinity()},
    {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
     -std::numeric_limits<float>::infinity()}};

float Middle(const FloatBox& box, std::size_t axis) { return box.lower[axis] + box.upper[axis]; }

/// Divides the boxes in two at the median of the longest axis of their middles.
std::size_t Divide(std::span<const FloatBox> boxes, std::span<std::uint32_t> part) {
  std::size_t longest = 0;
  float length = -1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [least, most] = std::ranges::minmax(
        part, {}, [&](std::uint32_t index) { return Middle(boxes[index], axis); });
    const float extent = Middle(boxes[most], axis) - Middle(boxes[least], axis);
    if (extent > length) length = extent, longest = axis;
  }
  const std::size_t half = part.size() / 2;
  const auto middle = [&](std::uint32_t index) {
    return std::pair(Middle(boxes[index], longest), index);
  };
  std::ranges::nth_element(part, part.begin() + static_cast<std::ptrdiff_t>(half), {}, middle);
  return half;
}

}  // namespace

FloatBox BoxAround(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) {
  FloatBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto low = static_cast<float>(lower[static_cast<int>(axis)]),
               high = static_cast<float>(upper[static_cast<int>(axis)]);
    const float margin = 4 * kEpsilon * std::max(std::fabs(low), std::fabs(high));
    box.lower[axis] = low - margin;
    box.upper[axis] = high + margin;
  }
  return box;
}

WideTree::Ray::Ray(const Eigen::Vector3d& from, const Eigen::Vector3d& along, double limit,
                   const Eigen::Vector3d& half) {
  // Below it, a component of the direction has the same effect as this.
  constexpr double kLeast = 1e-30;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    from_[at] = static_cast<float>(from[axis]);
    const double speed =
        std::fabs(along[axis]) < kLeast ? std::copysign(kLeast, along[axis]) : along[axis];
    inverse_[at] = static_cast<float>(1 / speed);
    near_[at] = speed < 0 ? 1 : 0;
    // Of rounding the start and the differences from it.
    slack_[at] =
        4 * kEpsilon * static_cast<float>(std::fabs(from[axis]) + std::fabs(along[axis]) * limit) +
        static_cast<float>(half[axis]) * (1 + 4 * kEpsilon);
  }
}

void WideTree::SetBox(Node& node, std::size_t child, const FloatBox& box) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    node.bounds[0][axis][child] = box.lower[axis];
    node.bounds[1][axis][child] = box.upper[axis];
  }
}

FloatBox WideTree::BoxOf(const Node& node) {
  FloatBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lower[axis] = std::ranges::min(node.bounds[0][axis]);
    box.upper[axis] = std::ranges::max(node.bounds[1][axis]);
  }
  return box;
}

std::int32_t WideTree::BuildNode(std::span<const FloatBox> boxes, std::span<std::uint32_t> part) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  Node& fresh = nodes_.emplace_back();
  fresh.children.fill(kNone);
  for (std::size_t child = 0; child < kWidth; ++child) SetBox(fresh, child, kNoBox);
  std::array<std::span<std::uint32_t>, kWidth> parts;
  if (part.size() <= kWidth) {
    for (std::size_t i = 0; i < part.size(); ++i) parts[i] = part.subspan(i, 1);
  } else {
    const std::size_t half = Divide(boxes, part);
    const std::span<std::uint32_t> halves[] = {part.first(half), part.subspan(half)};
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t quarter = halves[i].size() > 1 ? Divide(boxes, halves[i]) : 0;
      parts[2 * i] = halves[i].first(quarter);
      parts[2 * i + 1] = halves[i].subspan(quarter);
    }
  }
  for (std::size_t child = 0; child < kWidth; ++child) {
    if (parts[child].empty()) continue;
    const bool is_leaf = parts[child].size() == 1;
    const std::int32_t below =
        is_leaf ? ~static_cast<std::int32_t>(parts[child][0]) : BuildNode(boxes, parts[child]);
    Node& node = nodes_[static_cast<std::size_t>(index)];  // building may have moved it
    node.children[child] = below;
    SetBox(node, child,
           is_leaf ? boxes[parts[child][0]] : BoxOf(nodes_[static_cast<std::size_t>(below)]));
  }
  return index;
}

void WideTree::Build(std::span<const FloatBox> boxes) {
  nodes_.clear();
  if (boxes.empty()) return;
  nodes_.reserve(boxes.size() / 2 + 1);
  order_.resize(boxes.size());
  std::iota(order_.begin(), order_.end(), std::uint32_t{0});
  BuildNode(boxes, order_);
}

void WideTree::Refit(std::span<const FloatBox> boxes) {
  for (std::size_t i = nodes_.size(); i-- > 0;)
    for (std::size_t child = 0; child < kWidth; ++child) {
      const std::int32_t below = nodes_[i].children[child];
      if (below == kNone) continue;
      SetBox(nodes_[i], child,
             below < 0 ? boxes[static_cast<std::size_t>(~below)]
                       : BoxOf(nodes_[static_cast<std::size_t>(below)]));
    }
}

double WideTree::Cost() const {
  double sum = 0;
  for (const Node& node : nodes_) {
    const FloatBox box = BoxOf(node);
    const double x = box.upper[0] - box.lower[0], y = box.upper[1] - box.lower[1],
                 z = box.upper[2] - box.lower[2];
    sum += x * y + y * z + z * x;
  }
  return sum;
}

}  // namespace cdb::queries
