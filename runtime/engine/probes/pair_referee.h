// Holds what a detector found in a cycle against what there was to find (`record pairs`), between
// two cycles and never beside a timed one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/exact_pairs.h"
#include "runtime/engine/detection/adapter_broad_phase.h"
#include "runtime/engine/probes/exact_geometry.h"
#include "runtime/engine/world/engine.h"
#include "runtime/measure/recording.h"

namespace cdb::probes {

/// Pairs are held against brute force, in double, on the boxes that the broad phase was given in
/// that cycle: what a detector lists, before cdb drops anything; Bullet's own, by what they leave
/// in its cache. Contacts are held against closed forms, at the places where the detector looked.
/// Engine and recording must outlive it; the run records pairs. Not for several threads.
class PairReferee {
 public:
  PairReferee(world::Engine& engine, measure::Recording& recording);

  /// Call before and after each step that belongs to a recorded cycle.
  void BeforeStep();
  void AfterStep(std::uint64_t cycle);

 private:
  void ReadBoxes();
  std::vector<Pair> ListedPairs() const;
  void JudgePairs(std::uint64_t cycle);
  void JudgeContacts(std::uint64_t cycle);

  world::Engine& engine_;
  detection::AdapterBroadPhase* const seam_;  ///< null where the broad phase is Bullet's own
  const bool detects_;  ///< else there is nothing to judge, and nothing is stored
  std::span<std::int32_t> exact_pairs_, missed_pairs_, phantom_pairs_, duplicate_pairs_,
      missed_contacts_;
  std::span<double> depth_error_, normal_error_;
  std::vector<Box> boxes_;  ///< by user index; of a wall that does not stand, no numbers
  std::vector<Filter> filters_;
  std::vector<ExactOverlap> overlaps_;  ///< as the bodies stood before the step
};

}  // namespace cdb::probes
