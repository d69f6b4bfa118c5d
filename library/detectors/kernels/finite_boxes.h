// What the broad phases of other libraries share: a library is given the boxes that it can hold,
// and the others (planes without end, bodies that left the world) are tested one by one.
//
// Most libraries throw, overflow or lose their way on infinite sides. Where the same bodies stay
// within reach, the library keeps what it has built.
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
  /// `reach` in m: how far from 0 the library counts right. Bodies of which any side is farther, or
  /// no number, are not given to it.
  explicit FiniteBoxes(double reach = 1e100) : reach_(reach) {}

  /// The bodies are these from now on.
  virtual void Build(const Scene& scene, std::span<const Id> bodies) = 0;
  /// Every cycle: appends the pairs among the bodies of the last Build, a < b.
  virtual void ListPairs(const Scene& scene, std::vector<Pair>& pairs) = 0;

  static Pair Ordered(Id a, Id b) { return a < b ? Pair{a, b} : Pair{b, a}; }
  std::span<const Id> bodies() const { return within_; }

 private:
  /// True where other bodies are within reach than before.
  bool Part(const Scene& scene);
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
