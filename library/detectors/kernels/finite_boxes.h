// The common part of `octree` and the third-party broad phases: the detector gets the boxes that it
// can represent; the others (infinite planes, bodies that left the world) are tested one by one.
//
// Most libraries throw, overflow or return wrong pairs on infinite extents. As long as the same
// bodies stay within reach, the detector keeps its data structures.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::kernels {

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
