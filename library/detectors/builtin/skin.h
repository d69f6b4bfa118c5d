// `skin`: a Verlet list of candidate pairs that lasts for several cycles.
//
// Method: each box is enlarged by its expected displacement and a margin (fat box). The pairs of
// fat boxes, found by a grid, are the candidates. As long as boxes stay inside their fat boxes,
// only the candidates are tested, in double. The few boxes that escape get larger fat boxes, whose
// pairs are looked up in the grid and added to the candidates; boxes that escape repeatedly are
// untracked and looked up in every cycle. Once this has cost as much as a new list, the list is
// rebuilt. The walls that bound the room are candidates of the bodies whose fat boxes reach them.
// If no box has changed since the list was made, or all bodies sleep, the pairs are the same as
// before.
//
// The lifetime of a list is learnt: other lifetimes are tried and the better one is kept, judged by
// the number of tests, not by time, so that the same motion yields the same list in the same order.
// The motion model is learnt as well: boxes keep the velocity they had since the last list (or, if
// they turned round, at its end), or oscillate.
//
// A new list is built while the last one is in use, a part in each cycle, so that no cycle takes
// much longer than the others (skin_list.h). If boxes move in an unforeseen way, all of it is built
// at once. Cycles in which few bodies move do not age a list, and build little of the next one.
//
// Cost: reading the boxes and testing the candidates, or only those of the bodies that may have
// moved if these are few, and a part of a grid. Memory: about 380 bytes a body and 17 a candidate.
// Errors: bad_alloc. Threads: building a list and testing large lists use Options::threads; the
// pairs do not depend on them. Source: Verlet, Phys. Rev. 159, 1967.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "library/detectors/builtin/skin_changes.h"
#include "library/detectors/builtin/skin_list.h"
#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_parts.h"

namespace cdb::builtin {

class Skin final : public Detector {
 public:
  explicit Skin(const Options& options, const kernels::Kernels& kernels = kernels::BestKernels());

  void Prepare(const Scene& scene) override;
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override;
  bool FindChanges(const Scene& scene, std::vector<Pair>& came, std::vector<Pair>& went) override;

  /// Cost() is the cost of a body per cycle over the last list, including building it, or over this
  /// list so far if that is less. GridCost() is its cost with `grid`. Both in nanoseconds of a
  /// typical machine.
  double Cost() const;
  double GridCost() const;
  /// Work of the last cycle in the same unit, counted in boxes and pairs that were read.
  double Work() const { return work_; }
  /// See BoxGrid.
  double MeanOccupancy() const { return list_->grid.MeanOccupancy(); }
  double Crowding() const { return list_->grid.Crowding(); }
  /// Discards the list; call it if boxes have moved since the last call.
  void Forget() {
    is_built_ = sleeps_ = false;
    last_cost_ = 0;
    builder_.Cancel();
    changes_.Forget();
  }

 private:
  bool Follow(const Scene& scene, const SkinAwake* awake);
  void AppendRest(const Scene& scene, kernels::PairBuffer& pairs);
  void MakeList(const Scene& scene);
  void BuildAhead(const Scene& scene, bool have_few_moved);
  std::size_t FindEscaped(const Scene& scene, const SkinAwake* awake);
  std::size_t FindEscapedOfMoved(const Scene& scene, const SkinAwake& awake);
  bool TrackEscaped(const Scene& scene, const SkinAwake* awake);
  void LearnCost(double life);
  void UseNewList(const Scene& scene);
  double CyclesLeft() const;
  void FollowWalls(const Scene& scene);
  void AddWalls(const Scene& scene);
  void AddWallsOf(const Scene& scene, Id id, const kernels::FatBox* known);
  bool Regrow(const Scene& scene, Id id);
  std::size_t RegrowEscaped(const Scene& scene, std::size_t count);
  void AppendUntracked(const Scene& scene, kernels::PairBuffer& pairs);
  std::span<const Pair> Near(const kernels::FatBox& box, Id id);
  bool IsUnchanged(const Scene& scene) const;
  bool StillSleeps(const Scene& scene);

  const kernels::Kernels& kernels_;
  kernels::Bodies bodies_;
  kernels::PairParts parts_;
  std::unique_ptr<SkinList> list_;
  SkinListBuilder builder_;
  kernels::BoxGrid untracked_grid_;

  bool is_built_ = false;
  bool pairs_are_of_past_ = false;  ///< the last call's pairs are those of the boxes in list_->past
  bool parts_are_pairs_ = false;    ///< parts_ holds the last call's pairs
  bool sleeps_ = false;             ///< all movers were asleep in the last call
  Box last_room_ = {};              ///< the room in the last call
  std::uint32_t cycle_ = 0;
  unsigned age_ = 0;           ///< cycles of this list
  unsigned worn_ = 0;          ///< those of them in which more than a few bodies moved
  double building_share_ = 0;  ///< fraction of a cycle's work that building the next list may add
  std::uint32_t begin_ = 0;    ///< the cycle from which the next list is to be used

  std::size_t made_ = 0;  ///< candidates when the list was made
  std::vector<Id> escaped_, may_be_escaped_;
  struct FoundInPart {
    std::size_t begin, count;  ///< the first mover of the part; those that escaped
  };
  std::vector<FoundInPart> found_in_part_;
  std::vector<std::uint8_t> regrowths_, is_untracked_;  ///< of movers
  std::vector<Box> untracked_boxes_;
  std::size_t untracked_ = 0;  ///< of the last cycle
  kernels::PairBuffer raw_, rest_;
  SkinChanges changes_;
  std::size_t found_ = 0;  ///< pairs of the last cycle

  double horizon_ = 12, step_ = 1.5;  ///< intended lifetime in cycles; the factor tried next
  bool gets_longer_ = true;           ///< the lifetime, by this factor
  double making_cost_ = 0, cost_ = 0, escape_cost_ = 0;  ///< of this list: building; all; escapes
  double last_escape_cost_ = 0;                          ///< of the last cycle
  double last_cost_ = 0;                                 ///< mean of a cycle of the last list
  double last_tried_ = 0;  ///< mean of a cycle with the lifetime tried before
  double work_ = 0;        ///< of the last cycle
};

std::unique_ptr<Detector> MakeSkin(const Options& options,
                                   const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
