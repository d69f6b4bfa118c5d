// How the boxes of `skin` move: learnt from where they went since the last list, and used to
// enlarge them for the next one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {

/// The boxes of all bodies, each as it was in some cycle; that of a mover is known by its block.
struct PastBoxes {
  static constexpr std::size_t kBlock = 64;
  std::vector<Box> boxes;
  std::vector<std::uint32_t> cycles;  ///< of blocks of movers

  void Resize(std::size_t size) {
    boxes.resize(size);
    cycles.resize(size / kBlock + 1);
  }
  /// Movers `begin`, a multiple of kBlock, to `end` are, or are to be, as in this cycle.
  void SetCycle(std::size_t begin, std::size_t end, std::uint32_t cycle);
  std::uint32_t CycleOf(std::size_t mover) const { return cycles[mover / kBlock]; }
};

/// The motion model. Boxes keep the velocity they had since the last list (or, if they turned
/// round, at its end), or oscillate; whichever explains a sample of them better. Lengths in m,
/// times in cycles. Errors: bad_alloc. Threads: Fatten may run on several at once.
class SkinMotion {
 public:
  explicit SkinMotion(const kernels::Kernels& kernels) : kernels_(kernels) {}
  /// The number of bodies that Observe and Learn look at.
  static std::size_t SampleSize(std::size_t movers);
  /// Forgets all.
  void Prepare(std::size_t movers);
  /// The boxes keep their velocity.
  bool goes_on() const { return goes_on_; }
  /// For a first list, when nothing is known: a margin as large as it can be with few candidates.
  void Guess(const Scene& scene, std::size_t movers);
  /// Candidates of a body that were wanted then, if boxes were spread evenly.
  double guessed() const { return guessed_; }
  /// One or more cycles after Guess: looks where a sample went. Returns for how many cycles from
  /// the guess its margin is enough for nearly all.
  double Observe(const Scene& scene, std::size_t movers, const PastBoxes& past,
                 std::uint32_t cycle);
  /// Judges the models by a sample, which was in `past` when the last list was made.
  void Learn(const Scene& scene, std::size_t movers, const PastBoxes& past, std::uint32_t cycle);
  /// Remembers where movers `begin` to `end` are, for the velocities of those that turned round.
  void Mark(const Scene& scene, std::size_t begin, std::size_t end, std::uint32_t cycle);
  void ForgetMarks() { marked_ = 0; }
  /// The first movers, whose places are remembered.
  std::size_t marked() const { return marked_; }
  /// Learns the velocities and margins of movers `begin` to `end`.
  void LearnBodies(const Scene& scene, std::size_t begin, std::size_t end, const PastBoxes& past,
                   std::uint32_t cycle);
  /// Enlarges their boxes for the cycles `from` to `to` from now, by `share` of what is expected,
  /// and copies them to `past`.
  /// `longer`: the ratio of `to` to the cycles since the last list, as the errors of velocities add
  /// up.
  struct Span {
    double from, to, longer, share;
  };
  void Fatten(const Scene& scene, std::size_t begin, std::size_t end, const Span& span,
              kernels::FatBox* fat, const kernels::Columns& columns, PastBoxes& past) const;

 private:
  const kernels::Kernels& kernels_;
  bool goes_on_ = false;
  double margin_ = 0;  ///< covers the remaining motion of most boxes
  double most_margin_ = 0, most_speed_ = 0;
  double guessed_ = 0;
  std::vector<kernels::BodyMotion> motions_;  ///< of movers
  std::size_t marked_ = 0;
  PastBoxes marks_;
  std::vector<Box> observed_;  ///< a sample, in a cycle after the guess; empty if there was none
  std::uint32_t observed_in_ = 0;
};

}  // namespace cdb::builtin
