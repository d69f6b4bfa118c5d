// The motion of the boxes of `skin`: learnt from their displacements since the last list, and used
// to enlarge them for the next one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// The boxes of all bodies, each recorded in some cycle. The cycle is stored per block of movers.
struct PastBoxes {
  static constexpr std::size_t kBlock = 64;
  std::vector<Box> boxes;
  std::vector<std::uint32_t> cycles;  ///< of blocks of movers

  void Resize(std::size_t size) {
    boxes.resize(size);
    cycles.resize(size / kBlock + 1);
  }
  /// Sets the cycle in which the boxes of movers `begin` to `end` are recorded; `begin` is a
  /// multiple of kBlock.
  void SetCycle(std::size_t begin, std::size_t end, std::uint32_t cycle);
  std::uint32_t CycleOf(std::size_t mover) const { return cycles[mover / kBlock]; }
};

/// The motion model. Boxes keep the velocity they had since the last list (or, if they turned
/// round, at its end), or oscillate; whichever explains a sample of them better. Lengths in m,
/// times in cycles. Errors: bad_alloc. Threads: Fatten may run on several at once.
class SkinMotion {
 public:
  explicit SkinMotion(const kernels::Kernels& kernels) : kernels_(kernels) {}
  /// Number of bodies that Observe and Sample look at.
  static std::size_t SampleSize(std::size_t movers);
  /// Discards everything that was learnt.
  void Prepare(std::size_t movers);
  /// True if boxes are expected to keep their velocity.
  bool goes_on() const { return goes_on_; }
  /// For a first list, when nothing is known about the motion: chooses the largest margin that
  /// leaves few candidates.
  void Guess(const Scene& scene, std::size_t movers);
  /// The number of candidates per body that Guess aimed at, if boxes were spread evenly.
  double guessed() const { return guessed_; }
  /// One or more cycles after Guess: records the positions of a sample. Returns the number of
  /// cycles from the guess for which its margin is enough for nearly all.
  double Observe(const Scene& scene, std::size_t movers, const PastBoxes& past,
                 std::uint32_t cycle);
  /// Begins to judge the models anew.
  void StartSampling() {
    sampled_ = sample_size_ = 0;
    sample_speed_ = 0;
  }
  /// Records the displacements of `count` more bodies of the sample since `past`, recorded for the
  /// last list. True if the sample is complete; the models are then judged by it.
  bool Sample(const Scene& scene, std::size_t movers, const PastBoxes& past, std::uint32_t cycle,
              std::size_t count);
  /// Records the positions of movers `begin` to `end`, to measure the velocities of those that
  /// turned round.
  void Mark(const Scene& scene, std::size_t begin, std::size_t end, std::uint32_t cycle);
  void ForgetMarks() { marked_ = 0; }
  /// The number of movers whose positions are recorded, from the first on.
  std::size_t marked() const { return marked_; }
  /// Learns the velocities and margins of movers `begin` to `end`.
  void LearnBodies(const Scene& scene, std::size_t begin, std::size_t end, const PastBoxes& past,
                   std::uint32_t cycle);
  /// Enlarges their boxes for the cycles `from` to `to` from now, by `share` of the expected
  /// motion, and copies them to `past`. `longer`: the ratio of `to` to the cycles since the last
  /// list, because errors of velocities grow with time.
  struct Span {
    double from, to, longer, share;
  };
  void Fatten(const Scene& scene, std::size_t begin, std::size_t end, const Span& span,
              kernels::FatBox* fat, const kernels::Columns& columns, PastBoxes& past) const;

 private:
  static constexpr std::size_t kMostSample = 256;

  void Judge();

  const kernels::Kernels& kernels_;
  bool goes_on_ = false;
  double margin_ = 0;  ///< covers the remaining motion of most boxes
  double most_margin_ = 0, most_speed_ = 0;
  double guessed_ = 0;
  std::vector<kernels::BodyMotion> motions_;  ///< of movers
  std::size_t marked_ = 0;
  PastBoxes marks_;
  std::vector<Box> observed_;  ///< a sample, in a cycle after the guess; empty without a guess
  std::uint32_t observed_in_ = 0;
  // Displacements of the sample: whole ones, and deviations from constant velocities.
  std::array<double, kMostSample> resting_ = {}, going_ = {};
  std::size_t sampled_ = 0, sample_size_ = 0;
  double sample_speed_ = 0;  ///< sum
};

}  // namespace cdb::builtin
