// Compares the pairs and contacts of a detector with exact ones (`record pairs`), between cycles
// and never in a timed run.
#pragma once

#include <cstdint>
#include <vector>

#include "library/detectors/exact_pairs.h"
#include "runtime/engine/detection/adapter_broad_phase.h"
#include "runtime/engine/probes/exact_geometry.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/recording.h"

namespace cdb::probes {

/// Pairs are compared with brute force, in double, on the boxes of the cycle: the list of a
/// detector before cdb filters it, or, for Bullet's own broad phases, the pair cache. Contacts are
/// compared with closed forms, in the poses that the detector saw. Requires that the run records
/// pairs. Engine and recording must outlive it. Not thread-safe.
class PairReferee {
 public:
  PairReferee(world::Engine& engine, protocol::Recording& recording);

  /// Call before and after each step that belongs to a recorded cycle.
  void BeforeStep();
  void AfterStep(std::uint64_t cycle);

 private:
  void ReadBoxes();
  std::vector<Pair> ListedPairs() const;
  void JudgePairs(std::uint64_t cycle);
  void JudgeContacts(std::uint64_t cycle);

  world::Engine& engine_;
  detection::AdapterBroadPhase* const adapter_;  ///< null if the broad phase is Bullet's own
  const bool detects_;                           ///< otherwise nothing is compared or stored
  protocol::Recording& recording_;
  std::vector<Box> boxes_;  ///< by user index; NaN for absent walls
  std::vector<Filter> filters_;
  std::vector<ExactOverlap> overlaps_;  ///< in the poses before the step
};

}  // namespace cdb::probes
