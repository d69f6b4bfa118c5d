// `skin`: a list of candidates that lasts for several cycles.
//
// Method: each box is made fatter, by where it is likely to go and a margin for what it does
// besides; the pairs of fat boxes, found by a grid, are the candidates. As long as boxes stay in
// their fat ones, only candidates are tested, in double. The few that left (strays) get larger
// ones, whose pairs are looked up in the grid and join the candidates; those that leave these too
// (runners) are looked up in each cycle. When all that has cost as much as a new list, a new list
// is made. A cycle in which no box changed since the list was made gets the same pairs again.
//
// How long a list shall last is learnt: each length is tried and the better one kept, by the number
// of tests, never by the clock, so that the same motion gives the same list in the same order. How
// boxes move is learnt as well: on, as they did since the last list (those that were turned round,
// as at its end), or to and fro.
//
// Cost: reading the boxes and testing the candidates; now and then a grid. Memory: about 310 bytes
// a body and 8 a candidate. Errors: bad_alloc. Threads: Options::threads share the making of a list
// and large lists' tests; the pairs are the same.
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

  /// What a body took in a cycle of the last list, its making included, or of this list up to now
  /// if that is less; and would take in a cycle of `grid`. In nanoseconds of some machine.
  double Cost() const;
  double GridCost() const;
  /// See BoxGrid.
  double ContactCluster() const { return grid_.ContactCluster(); }
  /// Forgets the list: the boxes have moved unseen.
  void Forget() {
    is_built_ = false;
    last_cost_ = 0;
  }

 private:
  void MakeList(const Scene& scene);
  void LearnMotion(const Scene& scene);
  void LearnBodies(const Scene& scene);
  void LearnCost();
  void Fatten(const Scene& scene);
  bool FindCandidates(const Scene& scene, bool is_limited);
  bool Regrow(const Scene& scene, Id id);
  std::size_t RegrowStrays(const Scene& scene, std::size_t count);
  void AppendRunners(const Scene& scene, std::size_t count, kernels::PairBuffer& pairs);
  std::span<const Pair> Near(const kernels::FatBox& box, Id id);
  bool IsUnchanged(const Scene& scene) const;

  const kernels::Kernels& kernels_;
  kernels::Bodies bodies_;
  kernels::BoxGrid grid_, runner_grid_;
  kernels::FatBoxes regrown_;  ///< those that were strays, as they are now
  kernels::PairParts parts_;

  bool is_built_ = false;
  bool pairs_are_of_built_ = false;   ///< parts_ holds the pairs of built_
  std::vector<Box> built_;            ///< all boxes when the list was made
  std::vector<kernels::FatBox> fat_;  ///< of movers, in the grid or regrown_
  std::vector<Vec3> velocity_;        ///< of movers, a cycle, when the list was made
  std::vector<Box> recent_;           ///< of movers, when the list was `recent_age_` cycles old
  unsigned age_ = 0;                  ///< cycles of this list
  unsigned recent_age_ = 0;           ///< 0: nothing is remembered

  // How boxes move, learnt when a list ends.
  bool goes_on_ = false;         ///< they keep their velocity
  double margin_ = 0;            ///< for what most do besides
  std::vector<double> margins_;  ///< of movers, in this list
  double most_margin_ = 0, most_speed_ = 0;
  double share_ = 1;  ///< of all that, in this list

  kernels::PairBuffer candidates_;
  std::size_t made_ = 0;  ///< candidates when the list was made
  std::vector<Id> strays_;
  std::vector<std::uint8_t> regrowths_, is_runner_;  ///< of movers
  std::vector<Box> runner_boxes_;
  std::size_t runners_ = 0;  ///< of the last cycle
  kernels::PairBuffer raw_;

  double horizon_ = 12, step_ = 1.5;  ///< cycles that a list shall last; the factor tried next
  double making_cost_ = 0, cost_ = 0, stray_cost_ = 0;  ///< of this list; all of it
  double last_cost_ = 0;                                ///< of a cycle of the last list
  double last_tried_ = 0;                               ///< the same, with another horizon
};

std::unique_ptr<Detector> MakeSkin(const Options& options,
                                   const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
