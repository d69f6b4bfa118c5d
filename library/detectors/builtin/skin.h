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

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "library/detectors/builtin/skin_list.h"
#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"

namespace cdb::builtin {

// Scenes in which most bodies sleep: the candidates of `skin` whose bodies may have moved.

/// Keeps which bodies may have moved since the candidates were tested, and, if they are few, an
/// index of the candidates of each body. Cost: a few bytes a body in each cycle; the index 12 bytes
/// a candidate. Errors: bad_alloc. Not thread-safe.
class SkinAwake {
 public:
  /// Nothing is known about the last cycle: every body may have moved.
  void Forget() {
    last_asleep_.clear();
    ForgetIndex();
  }
  /// Candidates have been replaced or reordered.
  void ForgetIndex() {
    indexed_ = 0;
    few_cycles_ = 0;
  }
  /// Notes which bodies may have moved since the last cycle; call once in every cycle.
  void See(const Scene& scene);
  /// True if few bodies may have moved since the candidates were tested.
  bool HaveFewMoved() const { return kFew * moved_count_ <= may_have_moved_.size(); }
  /// Calls visit(id) for each body that may have moved since the candidates were tested.
  template <typename Visit>
  void ForEachMoved(const Visit& visit) const {
    for (std::size_t id = NextMoved(0); id < may_have_moved_.size(); id = NextMoved(id + 1))
      visit(static_cast<Id>(id));
  }
  /// Makes the index if few bodies may have moved for several cycles. True if there is one: call
  /// ForEach.
  bool UpdateIndex(const Scene& scene, std::span<const Pair> candidates);
  /// Calls test(i) for every candidate with a body that may have moved, for some twice, and for
  /// those appended since the index was made. After UpdateIndex.
  template <typename Test>
  void ForEach(std::span<const Pair> candidates, const Test& test) const {
    ForEachMoved([&](Id id) {
      for (std::uint32_t at = begins_[id]; at < begins_[id + 1]; ++at) test(entries_[at]);
    });
    for (std::size_t i = indexed_; i < candidates.size(); ++i) test(i);
  }
  /// All candidates have been tested, or those of ForEach.
  void Tested() {
    std::ranges::fill(may_have_moved_, std::uint8_t{0});
    moved_count_ = 0;
  }

 private:
  /// One in so many bodies may have moved.
  static constexpr std::size_t kFew = 8;

  /// The first body from `id` on that may have moved; the number of bodies if none has.
  std::size_t NextMoved(std::size_t id) const {
    const std::size_t size = may_have_moved_.size();
    const void* at = std::memchr(may_have_moved_.data() + id, 1, size - id);
    return at == nullptr ? size
                         : static_cast<std::size_t>(static_cast<const std::uint8_t*>(at) -
                                                    may_have_moved_.data());
  }
  void MakeIndex(const Scene& scene, std::span<const Pair> candidates);

  std::vector<std::uint8_t> last_asleep_;     ///< in the last cycle; empty if unknown
  std::vector<std::uint8_t> may_have_moved_;  ///< since the candidates were tested
  std::size_t moved_count_ = 0;               ///< bodies in may_have_moved_
  unsigned few_cycles_ = 0;                   ///< in a row, with these candidates
  std::size_t indexed_ = 0;                   ///< candidates in the index; 0 without one
  std::vector<std::uint32_t> begins_;         ///< of the entries of each body; and the end
  std::vector<std::uint32_t> entries_;        ///< candidates by body, each twice
};

// The pairs that `skin` listed last, so that it can list only the changes.

/// Keeps a flag for each candidate: whether its boxes overlapped in the last call. Cost: testing
/// the candidates, of few awake bodies if most sleep, plus the number of changes. Errors:
/// bad_alloc. Threads: one caller; the tests use the threads of `parts`.
class SkinChanges {
 public:
  explicit SkinChanges(kernels::PairParts& parts) : parts_(parts) {}

  /// Makes the next call of Find list all pairs.
  void Forget();
  /// Call before the candidates are replaced or reordered.
  void Replace(std::span<const Pair> candidates);
  /// Notes which bodies may have moved since the last cycle; call once in a cycle, before Find or
  /// in its place if the pairs are the same as in the last cycle.
  const SkinAwake& See(const Scene& scene) {
    awake_.See(scene);
    return awake_;
  }
  /// Lists the changes as Detector::FindChanges does. Candidates may have been appended since the
  /// last call; `rest` are the pairs of overlapping boxes that are not candidates.
  bool Find(const Scene& scene, const kernels::Kernels& kernels, std::span<const Pair> candidates,
            std::span<const Pair> rest, std::vector<Pair>& came, std::vector<Pair>& went);
  /// True if Find has been called since the last Forget.
  bool knows_last() const { return knows_last_; }
  /// Number of pairs in the last call of Find.
  std::size_t size() const { return met_count_ + rest_.size(); }

 private:
  void FindAll(const Scene& scene, const kernels::Kernels& kernels,
               std::span<const Pair> candidates);
  void FindAwake(const Scene& scene, std::span<const Pair> candidates);
  void FindRest(const Scene& scene, std::span<const Pair> rest, std::vector<Pair>& came,
                std::vector<Pair>& went);

  kernels::PairParts& parts_;
  bool knows_last_ = false;
  bool has_flags_ = false;          ///< met_ has the flags of the candidates in use
  std::vector<std::uint64_t> met_;  ///< a bit for each candidate; see Kernels::find_changed
  std::size_t met_count_ = 0;
  std::vector<Pair> replaced_;  ///< candidates that overlapped when they were replaced
  std::vector<Pair> rest_;      ///< of the last call
  std::vector<Pair> changed_;
  SkinAwake awake_;
};

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

// The cost model of `skin`: constants that estimate the work of a cycle.

// In nanoseconds, measured once on one machine; only their ratios matter.
inline constexpr double kGridCost = 38;                   ///< of a body in a cycle of `grid`
inline constexpr double kListCost = 80, kListedCost = 1;  ///< of making a list: a body, a candidate
inline constexpr double kOccupancyCost = 0.1;  ///< of each other body in the cell, or oversized
inline constexpr double kReadCost = 1.4;  ///< of reading a box in a cycle that does nothing else
inline constexpr double kCheckCost = 3, kTestCost = 2.2, kRegrowCost = 250, kUntrackedCost = 100;

/// Cost of a cycle for `escaped` bodies, of which `untracked` are looked up in every cycle.
inline double CostOfEscaped(std::size_t escaped, std::size_t untracked) {
  return kRegrowCost * static_cast<double>(escaped - untracked) +
         kUntrackedCost * static_cast<double>(untracked);
}

}  // namespace cdb::builtin
