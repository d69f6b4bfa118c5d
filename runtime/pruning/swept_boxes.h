// Which of many boxes overlap: by one pass over them in the order of one axis.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "runtime/pruning/trajectory.h"

namespace cdb::pruning {

inline constexpr std::size_t kSweepKinds = 4;

struct SweptBox {
  Box box;
  std::uint32_t object = 0;
  std::uint8_t kind = 0;  ///< below kSweepKinds
};

/// The axis along which the boxes are shortest for the room that they are in.
int BestSweepAxis(const std::vector<SweptBox>& boxes);

/// Bit b of entry a: a box of kind a is tested against those of kind b. Must be symmetric.
using SweepPartners = std::array<std::uint8_t, kSweepKinds>;

/// Calls `report` once for each two boxes of partner kinds that overlap or touch. Takes one from
/// `tests_left` for each two that overlap along the axis; false, and not all reported, where there
/// are more. No box may hold a NaN.
bool Sweep(std::vector<SweptBox> boxes, const SweepPartners& partners, std::uint64_t& tests_left,
           const std::function<void(std::uint32_t, std::uint32_t)>& report);

}  // namespace cdb::pruning
