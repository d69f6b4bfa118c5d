// Finds overlapping pairs in a large set of boxes by one sweep along an axis, and the boxes near
// another one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "runtime/omissions/trajectory.h"

namespace cdb::omissions {

inline constexpr std::size_t kSweepKinds = 4;

struct SweptBox {
  Box box;
  std::uint32_t object = 0;
  std::uint8_t kind = 0;  ///< below kSweepKinds
};

/// The axis along which the boxes are shortest relative to the extent of all boxes.
int BestSweepAxis(const std::vector<SweptBox>& boxes);

/// Bit b of entry a: a box of kind a is tested against those of kind b. Must be symmetric.
using SweepPartners = std::array<std::uint8_t, kSweepKinds>;

/// Calls `report` once for each pair of boxes of partner kinds that overlap or touch. Decrements
/// `tests_left` for each pair that overlaps along the axis; if it runs out, returns false without
/// reporting all pairs. No box may contain a NaN.
bool Sweep(std::vector<SweptBox> boxes, const SweepPartners& partners, std::uint64_t& tests_left,
           const std::function<void(std::uint32_t, std::uint32_t)>& report);

/// Boxes sorted along their best axis, for queries by a box.
class SortedBoxes {
 public:
  SortedBoxes() = default;
  /// No box may contain a NaN.
  explicit SortedBoxes(std::vector<SweptBox> boxes);

  /// All boxes that overlap `box` along the axis, and some more.
  std::span<const SweptBox> Near(const Box& box) const;

 private:
  int axis_ = 0;
  double longest_ = 0;
  std::vector<SweptBox> boxes_;
};

}  // namespace cdb::omissions
