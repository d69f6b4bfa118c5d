// The fat boxes of a few bodies, tested with a box eight at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::kernels {

/// The box in floats, rounded outwards; unchanged if its coordinates are floats.
inline FatBox Around(const Box& box, const Kernels& kernels) {
  FatBox around;
  kernels.narrow(&box, 1,
                 {{around.lower, around.lower + 1, around.lower + 2},
                  {around.upper, around.upper + 1, around.upper + 2}});
  return around;
}

/// Errors: bad_alloc, only from Clear. Threads: one at a time.
class FatBoxes {
 public:
  /// Removes all boxes; bodies are 0 to `bodies`.
  void Clear(std::size_t bodies) {
    columns_.Reserve(bodies);
    count_ = 0;
    ids_.resize(bodies + kReadPast);
    place_.assign(bodies, kNone);
  }
  bool Has(Id id) const { return place_[id] != kNone; }
  /// Replaces the box of the body, if any.
  void Put(Id id, const FatBox& box) {
    if (!Has(id)) {
      ids_[count_] = id;
      place_[id] = count_++;
    }
    for (int axis = 0; axis < 3; ++axis) {
      columns_.get().lower[axis][place_[id]] = box.lower[axis];
      columns_.get().upper[axis][place_[id]] = box.upper[axis];
    }
  }
  /// Pairs (id, other) of a box with all of them, including its own if present.
  void QueryOne(const FatBox& box, Id id, const Kernels& kernels, PairSink& sink) const {
    // An empty grid of one cell, for which all boxes are oversized.
    static constexpr std::uint32_t kStarts[2] = {0, 0};
    static constexpr GridShape kShape = {
        .origin = {}, .inverse = {}, .last = {}, .reach = {}, .n = {1, 1, 1}};
    kernels.query_one({columns_.get(), ids_.data(), kStarts, 0, count_}, kShape, box.lower,
                      box.upper, id, sink);
  }

 private:
  static constexpr std::size_t kReadPast = 8;
  static constexpr std::uint32_t kNone = ~0u;
  std::uint32_t count_ = 0;
  SoaBoxes columns_;
  std::vector<Id> ids_;
  std::vector<std::uint32_t> place_;
};

}  // namespace cdb::kernels
