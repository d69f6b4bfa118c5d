// Points and paths in a solid, in the axes of its body and in double.
//
// Threads: any. Errors: none.
#pragma once

#include "library/objects/solid.h"

namespace cdb::probes {

/// The point lies in the solid or on its surface.
bool Contains(const objects::Solid& solid, const Eigen::Vector3d& point);

/// A ball of this radius, m, that moves straight from one point to the other meets the solid.
bool MeetsPath(const objects::Solid& solid, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
               double radius = 0);

/// The solid with each side shorter by `part` of its least side, about the centre of mass; a
/// compound as it is.
objects::Solid CoreOf(const objects::Solid& solid, double part);

}  // namespace cdb::probes
