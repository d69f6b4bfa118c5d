// Kinematic objects: they follow their velocities or their path, whatever they touch.
#pragma once

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// The word of `mass` that makes an object kinematic.
inline constexpr std::string_view kKinematicWord = "kinematic";

/// True if the group has objects, and all or some of them may be kinematic.
bool HasKinematic(const plan::Group& group);

}  // namespace cdb::analysis
