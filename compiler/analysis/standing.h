// Finds out whether objects at given points stand on the floor or on other objects.
#pragma once

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// True if the objects of the group are placed in a box of their own, which may be above the floor,
/// rather than in the cube.
inline bool IsInBox(const plan::GroupSettings& settings) {
  return schema::AsCall(settings.Get("region")) != nullptr;
}

/// True if all objects of `group`, which has `location at`, are upright cuboids or cylinders whose
/// lower face touches the floor, an object of a stack or another object at a given point, or is
/// above it by at most a twentieth of the object's least side, and whose centre, with all that it
/// bears, is above the face that bears it. False if that does not follow from the plan, because
/// sizes are drawn, for example.
bool StandsOnOthers(const plan::Scene& scene, const plan::Group& group);

}  // namespace cdb::analysis
