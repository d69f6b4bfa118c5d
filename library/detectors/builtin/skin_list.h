// The candidate pairs of `skin`, and how a new list of them is built over several cycles while the
// last one is in use.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"

namespace cdb::builtin {

// The motion of the boxes of `skin`: learnt from their displacements since the last list, and used
// to enlarge them for the next one.

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

/// The pairs of movers whose fat boxes overlap.
struct SkinList {
  explicit SkinList(const kernels::Kernels& kernels) : grid(kernels) {}
  /// Allocates memory for the bodies in advance, because the first use of new memory is slow.
  void Reserve(const Scene& scene, std::size_t movers);

  kernels::BoxGrid grid;             ///< of fat boxes
  std::vector<kernels::FatBox> fat;  ///< of movers
  PastBoxes past;                    ///< the boxes that were enlarged
  kernels::PairBuffer candidates;
  bool goes_on = false;   ///< boxes are expected to keep their velocity until `end`
  double horizon = 0;     ///< intended lifetime in cycles
  double end = 0;         ///< the last cycle for which boxes are enlarged
  bool is_guess = false;  ///< made before anything was known about the motion
  double life = 0;        ///< of a guess: cycles for which it is expected to last
};

/// Builds a list in steps of bounded cost. Each step enlarges the boxes of some movers as they are
/// in that cycle, or works on the grid of all fat boxes; no cycle copies all boxes. A box may leave
/// its fat box before the list is in use, just as it may later. Costs are in nanoseconds of a
/// typical machine and depend on numbers of boxes and pairs only, so that the same motion yields
/// the same list. Errors: bad_alloc. Threads: one caller; large steps use those of `parts`.
class SkinListBuilder {
 public:
  SkinListBuilder(const kernels::Kernels& kernels, kernels::PairParts& parts)
      : next_(std::make_unique<SkinList>(kernels)), parts_(parts), motion_(kernels) {}

  /// A budget that is never used up.
  static constexpr double kUnlimited = 1e15;

  void Prepare(const Scene& scene, std::size_t movers);
  /// The cycle from which the list is to be used, and its lifetime in cycles.
  struct Plan {
    std::uint32_t begin;
    double horizon;
  };
  /// Starts a list. `last` is null if boxes have not been seen before; it must not change until the
  /// list is done.
  void Start(const Scene& scene, const kernels::Bodies& bodies, const Plan& plan,
             const SkinList* last);
  /// In a cycle after a first list was made: estimates the number of cycles that it will last.
  void Observe(const Scene& scene, std::uint32_t cycle, SkinList& guess);
  void Cancel() { stage_ = Stage::kIdle; }
  /// Records the present positions of some more boxes in the cycles before Start, to measure the
  /// velocities of those that turned round. Returns the cost, which is about `budget` until all are
  /// done.
  double Mark(const Scene& scene, std::uint32_t cycle, double budget);
  bool is_building() const { return stage_ != Stage::kIdle; }
  /// True if all boxes are enlarged: the list can be finished in one cycle for less than a new one
  /// costs.
  bool is_half_done() const { return stage_ > Stage::kFatten; }
  /// Works for `budget`, which is reduced by the cost. True if the list is done; call Take from the
  /// planned cycle on.
  bool Advance(const Scene& scene, const kernels::Bodies& bodies, std::uint32_t cycle,
               double& budget);
  /// Exchanges the new list for `list`, whose memory the next one reuses.
  void Take(std::unique_ptr<SkinList>& list);

  /// Cost of a whole list, predicted from the last one, and the part of it that remains.
  double WholeCost() const { return whole_cost_; }
  double CostLeft() const;

 private:
  enum class Stage { kIdle, kSample, kFatten, kArrange, kQuery, kDone };

  void Sample(const Scene& scene, std::uint32_t cycle, double& budget);
  void Fatten(const Scene& scene, std::uint32_t cycle, double& budget);
  void Query(const Scene& scene, const kernels::Bodies& bodies, double& budget);
  void QueryFree(const Scene& scene, const kernels::Bodies& bodies, double& budget);
  std::size_t LookUps(const kernels::Bodies& bodies) const;
  template <typename LookUp>
  void FindCandidates(const Scene& scene, const kernels::Bodies& bodies, std::size_t step,
                      double cost, const LookUp& look_up, double& budget);
  void Shrink();

  std::unique_ptr<SkinList> next_;
  kernels::PairParts& parts_;
  SkinMotion motion_;
  const SkinList* last_ = nullptr;
  Plan plan_ = {};
  Stage stage_ = Stage::kIdle;
  std::size_t movers_ = 0, cursor_ = 0, learnt_ = 0;
  /// Pairs of overlapping fat boxes found so far, including those that may not collide.
  std::size_t found_ = 0;
  double last_found_ = 0;  ///< for each mover, when the last list was built
  double share_ = 1;       ///< fraction of the expected motion that this list covers
  double spent_ = 0, whole_cost_ = 0;
};

}  // namespace cdb::builtin
