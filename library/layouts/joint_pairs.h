// The pairs of objects that the joints of a scene join.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::layouts {

struct JointPair {
  static constexpr std::size_t kWorld = std::numeric_limits<std::size_t>::max();
  const plan::Joint* joint;
  std::size_t parent, child;  ///< indices of objects, or kWorld
};

/// In the order of the joints, then of the objects: object i of one group with object i of the
/// other, or a single one, or the world, with each. The joints have no JointFault
/// (compiler/analysis/joints.h); those without objects have no pairs. The scene must outlive it.
std::vector<JointPair> JointPairsOf(const plan::Scene& scene);

}  // namespace cdb::layouts
