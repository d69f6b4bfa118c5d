// Kinematic objects: they move as their velocities or their path say, whatever they meet.
#pragma once

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// The word of `mass` that makes an object kinematic.
inline constexpr std::string_view kKinematicWord = "kinematic";

/// The group has objects, and they are kinematic, or some of them may be drawn to be.
bool HasKinematic(const plan::Group& group);

}  // namespace cdb::analysis
