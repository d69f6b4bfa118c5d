// The nodes of soft bodies (compiler/analysis/soft.h) at the start.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::layouts {

/// m: the place of each node of a soft body, relative to its position. Its solid is the box of the
/// nodes with the margin around them.
std::vector<Eigen::Vector3d> NodesAbout(const plan::Scene& scene, const ObjectState& object);

}  // namespace cdb::layouts
