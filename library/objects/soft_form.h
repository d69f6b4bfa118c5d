// Soft solids of a mesh: `type soft("bunny.ply", cells: 16)`.
//
// Errors: SceneError if the file is missing or differs from the plan's, its mesh is no solid or has
// no good tetrahedra. Threads: any. Takes up to seconds the first time on a machine, for some
// 100,000 tetrahedra (library/content_cache.h).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "compiler/analysis/soft.h"
#include "compiler/schema/value.h"

namespace cdb::objects {

struct SoftForm {
  analysis::SoftMesh mesh;      ///< in the box around the mesh of the file
  Eigen::Vector3d proportions;  ///< sides of this box, the longest 1
  double native_side = 0;       ///< m: the longest side
  double volume_ratio = 1;      ///< of the tetrahedra over that of the mesh
  double error = 0;             ///< volume of either outside the other, over that of the mesh
  double distance = 0;          ///< of a vertex of the mesh from the surface, at most; in cells
  double least_angle = 0, most_angle = 0;  ///< degrees, between faces, at the file's proportions
  std::string left_out;                    ///< parts of the file: library/meshes/mesh.h

  /// m, along the axes; a size of 0 is native.
  Eigen::Vector3d SidesOf(double size, const Eigen::Vector3d& aspect) const;
};

/// `type`: a call of soft( ).
std::shared_ptr<const SoftForm> SoftFormOf(const schema::Call& type);
/// `388 nodes, 1393 tetrahedra, …`, for `cdb check`.
std::string TextOf(const SoftForm& form);

/// The mesh of a type of soft bodies, whether it is made of a file or not.
analysis::SoftMesh SoftMeshOf(const schema::Value& type);

}  // namespace cdb::objects
