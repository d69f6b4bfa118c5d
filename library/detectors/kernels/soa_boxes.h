// Memory for boxes as columns of floats.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "library/detectors/detector.h"
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

// The common part of `octree` and the third-party broad phases: the detector gets the boxes that it
// can represent; the others (infinite planes, bodies that left the world) are tested one by one.
//
// Most libraries throw, overflow or return wrong pairs on infinite extents. As long as the same
// bodies stay within reach, the detector keeps its data structures.

/// Threads: one, as every detector.
class FiniteBoxes : public Detector {
 public:
  void Prepare(const Scene& scene) final;
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) final;

 protected:
  /// `reach`, in m: the distance from the origin up to which the detector is correct. It does not
  /// get bodies that extend beyond, or whose box has a NaN.
  explicit FiniteBoxes(double reach = 1e100) : reach_(reach) {}

  /// Sets the bodies.
  virtual void Build(const Scene& scene, std::span<const Id> bodies) = 0;
  /// Every cycle: appends the pairs among the bodies of the last Build, a < b.
  virtual void ListPairs(const Scene& scene, std::vector<Pair>& pairs) = 0;

  static Pair Ordered(Id a, Id b) { return a < b ? Pair{a, b} : Pair{b, a}; }
  std::span<const Id> bodies() const { return within_; }

 private:
  /// Finds the bodies within reach. True if they have changed.
  bool UpdateBodies(const Scene& scene);
  void ListOthers(const Scene& scene, std::vector<Pair>& pairs) const;

  double reach_;
  std::vector<std::uint8_t> is_within_;
  std::vector<Id> within_, others_;
};

template <typename T>
Detector* MakeDetector(const Options&) {
  return new T;
}

}  // namespace cdb::kernels
