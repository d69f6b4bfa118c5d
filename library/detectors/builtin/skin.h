// `skin`: a Verlet list of candidate pairs that lasts for several cycles.
//
// Method: each box is enlarged by its expected displacement and a margin (fat box). The pairs of
// fat boxes, found by a grid, are the candidates. As long as boxes stay inside their fat boxes,
// only the candidates are tested, in double. The few escaped boxes get larger fat boxes, whose
// pairs are looked up in the grid and added to the candidates; those that escape again are
// untracked and looked up in every cycle. Once this has cost as much as a new list, the list is
// rebuilt. If no box has changed since the list was made, or all bodies sleep, the pairs are the
// same as before.
//
// The lifetime of a list is learnt: other lifetimes are tried and the better one is kept, judged by
// the number of tests, not by time, so that the same motion yields the same list in the same order.
// The motion model is learnt as well: boxes keep the velocity they had since the last list (or, if
// they turned round, at its end), or oscillate.
//
// Cost: reading the boxes and testing the candidates; occasionally a grid. Memory: about 310 bytes
// a body and 8 a candidate. Errors: bad_alloc. Threads: building a list and testing large lists use
// Options::threads; the pairs do not depend on them.
// Source: Verlet, Phys. Rev. 159, 1967.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/fat_boxes.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_parts.h"

namespace cdb::builtin {

class Skin final : public Detector {
 public:
  explicit Skin(const Options& options, const kernels::Kernels& kernels = kernels::BestKernels());

  void Prepare(const Scene& scene) override;
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override;

  /// Cost of a body per cycle of the last list, including building it, or of this list so far if
  /// that is less; GridCost: its cost with `grid`. In nanoseconds of a typical machine.
  double Cost() const;
  double GridCost() const;
  /// See BoxGrid.
  double MeanOccupancy() const { return grid_.MeanOccupancy(); }
  /// Discards the list, because boxes have moved since the last call.
  void Forget() {
    is_built_ = sleeps_ = false;
    last_cost_ = 0;
  }

 private:
  void MakeList(const Scene& scene);
  void LearnMotion(const Scene& scene);
  void LearnBodies(const Scene& scene);
  void LearnCost();
  void Fatten(const Scene& scene);
  bool FindCandidates(const Scene& scene, bool is_limited);
  void FindNearWalls();
  bool Regrow(const Scene& scene, Id id);
  std::size_t RegrowEscaped(const Scene& scene, std::size_t count);
  void AppendUntracked(const Scene& scene, std::size_t count, kernels::PairBuffer& pairs);
  std::span<const Pair> Near(const kernels::FatBox& box, Id id);
  bool IsUnchanged(const Scene& scene) const;
  bool StillSleeps(const Scene& scene);

  const kernels::Kernels& kernels_;
  kernels::Bodies bodies_;
  kernels::BoxGrid grid_, runner_grid_;
  kernels::FatBoxes regrown_;  ///< the fat boxes of escaped bodies
  kernels::PairParts parts_;

  bool is_built_ = false;
  bool pairs_are_of_built_ = false;   ///< parts_ holds the pairs of built_
  bool sleeps_ = false;               ///< all movers were asleep in the last call
  Box last_room_ = {};                ///< in the last call
  std::vector<Box> built_;            ///< all boxes when the list was made
  std::vector<kernels::FatBox> fat_;  ///< of movers, in the grid or regrown_
  std::vector<Vec3> velocity_;        ///< of movers, per cycle, when the list was made
  std::vector<Box> recent_;           ///< of movers, when the list was `recent_age_` cycles old
  unsigned age_ = 0;                  ///< cycles of this list
  unsigned recent_age_ = 0;           ///< 0 if there are none

  // The motion model, learnt when a list ends.
  bool goes_on_ = false;         ///< boxes keep their velocity
  double margin_ = 0;            ///< covers the remaining motion of most boxes
  std::vector<double> margins_;  ///< of movers, in this list
  double most_margin_ = 0, most_speed_ = 0;
  double share_ = 1;  ///< of all that, in this list

  Box room_ = {};               ///< between the walls, when the list was made
  std::vector<Id> near_walls_;  ///< movers whose fat boxes do not lie inside it

  kernels::PairBuffer candidates_;
  std::size_t made_ = 0;  ///< candidates when the list was made
  std::vector<Id> escaped_;
  std::vector<std::uint8_t> regrowths_, is_untracked_;  ///< of movers
  std::vector<Box> untracked_boxes_;
  std::size_t untracked_ = 0;  ///< of the last cycle
  kernels::PairBuffer raw_;

  double horizon_ = 12, step_ = 1.5;  ///< intended lifetime in cycles; the factor tried next
  double making_cost_ = 0, cost_ = 0, stray_cost_ = 0;  ///< of this list; all of it
  double last_cost_ = 0;                                ///< of a cycle of the last list
  double last_tried_ = 0;                               ///< the same, with another horizon
};

std::unique_ptr<Detector> MakeSkin(const Options& options,
                                   const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
