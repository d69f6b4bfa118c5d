// The candidate pairs of `skin`, and how a new list of them is built over several cycles while the
// last one is in use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "library/detectors/builtin/skin_motion.h"
#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"
#include "library/detectors/kernels/pair_parts.h"

namespace cdb::builtin {

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
