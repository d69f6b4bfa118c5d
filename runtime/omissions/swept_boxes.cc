#include "runtime/omissions/swept_boxes.h"

#include <algorithm>

namespace cdb::omissions {
int BestSweepAxis(const std::vector<SweptBox>& boxes) {
  Box room;
  Eigen::Vector3d lengths = Eigen::Vector3d::Zero();
  for (const SweptBox& swept : boxes) {
    room.extend(swept.box);
    lengths += swept.box.sizes();
  }
  int best = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (lengths[axis] * room.sizes()[best] < lengths[best] * room.sizes()[axis]) best = axis;
  return best;
}

bool Sweep(std::vector<SweptBox> boxes, const SweepPartners& partners, std::uint64_t& tests_left,
           const std::function<void(std::uint32_t, std::uint32_t)>& report) {
  const int axis = BestSweepAxis(boxes);
  std::ranges::sort(boxes, {}, [&](const SweptBox& swept) { return swept.box.min()[axis]; });
  std::array<std::vector<const SweptBox*>, kSweepKinds> open;
  for (const SweptBox& swept : boxes) {
    for (std::size_t kind = 0; kind < kSweepKinds; ++kind) {
      if ((partners[swept.kind] >> kind & 1) == 0) continue;
      auto& others = open[kind];
      for (std::size_t i = 0; i < others.size();) {
        const SweptBox& other = *others[i];
        if (other.box.max()[axis] < swept.box.min()[axis]) {
          others[i] = others.back();
          others.pop_back();
          continue;
        }
        if (tests_left == 0) return false;
        --tests_left;
        if (swept.box.intersects(other.box)) report(swept.object, other.object);
        ++i;
      }
    }
    open[swept.kind].push_back(&swept);
  }
  return true;
}

SortedBoxes::SortedBoxes(std::vector<SweptBox> boxes)
    : axis_(BestSweepAxis(boxes)), boxes_(std::move(boxes)) {
  for (const SweptBox& swept : boxes_) longest_ = std::max(longest_, swept.box.sizes()[axis_]);
  std::ranges::sort(boxes_, {}, [&](const SweptBox& swept) { return swept.box.min()[axis_]; });
}

std::span<const SweptBox> SortedBoxes::Near(const Box& box) const {
  const auto least = [&](const SweptBox& swept) { return swept.box.min()[axis_]; };
  const auto begin = std::ranges::lower_bound(boxes_, box.min()[axis_] - longest_, {}, least);
  const auto end = std::ranges::upper_bound(begin, boxes_.end(), box.max()[axis_], {}, least);
  return {begin, end};
}

}  // namespace cdb::omissions
