// The least distance between a robot and itself or the scene (`configurations.ask distance`).
#pragma once

#include <utility>
#include <vector>

#include "library/layouts/initial_state.h"
#include "library/robots/kinematic_tree.h"
#include "runtime/engine/world/engine.h"

namespace cdb::worker {

/// Pairs of objects that may touch, one of them a link that moves. By GJK, in double, the pairs
/// with the nearest boxes first. Not thread-safe; the engine must outlive it.
class LeastDistance {
 public:
  LeastDistance(const world::Engine& engine, const robots::KinematicTree& tree);

  /// m; 0 if two of them overlap, infinite if there are none. `poses`: by object.
  double Of(const std::vector<objects::Pose>& poses);
  /// The same by the referee (library/exact/signed_distance.h), for all pairs.
  double ExactOf(const std::vector<objects::Pose>& poses) const;

 private:
  struct Candidate {
    double bound;  ///< m, from below
    std::size_t pair;
  };

  const std::vector<layouts::ObjectState>& objects_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  std::vector<objects::Box> boxes_;
  std::vector<Candidate> candidates_;
};

}  // namespace cdb::worker
