// Memory for boxes as columns of floats.
#pragma once

#include <array>
#include <memory>

#include "library/detectors/kernels/kernels.h"

namespace cdb::kernels {

/// Six columns of `count` floats with padding that may be read. Grows, never shrinks; growing loses
/// the contents. Errors: bad_alloc. Threads: one at a time.
class SoaBoxes {
 public:
  void Reserve(std::size_t count) {
    if (count <= capacity_ && floats_ != nullptr) return;
    capacity_ = count + count / 8;
    // Zero-initialised, because values past the end are read and discarded. The extra stride keeps
    // columns whose size is a power of two from sharing cache sets.
    const std::size_t step = (capacity_ + 16 + 15) / 16 * 16 + 16;
    floats_ = std::make_unique<float[]>(6 * step);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      columns_.lower[axis] = floats_.get() + axis * step;
      columns_.upper[axis] = floats_.get() + (axis + 3) * step;
    }
  }
  const Columns& get() const { return columns_; }

 private:
  std::size_t capacity_ = 0;
  std::unique_ptr<float[]> floats_;
  Columns columns_ = {};
};

}  // namespace cdb::kernels
