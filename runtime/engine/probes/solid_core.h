// Tests of points and paths against a solid, in the axes of its body and in double.
//
// Threads: any. Errors: none.
#pragma once

#include "library/objects/solid.h"

namespace cdb::probes {

/// True if the point lies in the solid or on its surface.
bool Contains(const objects::Solid& solid, const Eigen::Vector3d& point);

/// True if a ball of this radius, m, that moves straight from one point to the other meets the
/// solid.
bool MeetsPath(const objects::Solid& solid, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
               double radius = 0);

/// The solid, shrunk about the centre of mass: each side is shorter by `part` of the least side. A
/// compound is returned unchanged.
objects::Solid CoreOf(const objects::Solid& solid, double part);

}  // namespace cdb::probes
