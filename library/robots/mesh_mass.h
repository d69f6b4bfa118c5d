// The mass and inertia of a mesh of a robot, by the rules of the formats.
//
// SI units. Errors: library::SceneError if the mesh cannot be read, or has no mass by that rule.
// Threads: any. Sources: the specification of SDF, `<inertial auto>`; the XML reference of MuJoCo,
// asset/mesh/inertia.
#pragma once

#include "compiler/analysis/robot.h"

namespace cdb::robots {

enum class MeshMass {
  kSolid,  ///< what is within the mesh, which must be closed
  kHull,   ///< its convex hull
  kShell,  ///< its surface
  /// The tetrahedra from the mean of the surface to each face, each counted as positive: more than
  /// the volume if the mesh is not star-shaped about that point. MuJoCo's default.
  kUnsigned,
};

/// Of a mesh with a density of 1 kg/m^3, or kg/m^2 of a shell, in the frame of its link.
analysis::RobotInertia InertiaOfMesh(const analysis::RobotShape& shape, MeshMass rule);

}  // namespace cdb::robots
