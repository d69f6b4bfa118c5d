// A deforming mesh: the same triangles in each frame, and the positions of their vertices over
// time.
//
// Errors: SceneError, with the file, the cause and the remedy. Threads: any.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/mesh.h"

namespace cdb::deforming {

using meshes::Triangle;

struct MeshSequence {
  std::vector<Triangle> triangles;
  std::vector<std::vector<Eigen::Vector3d>> frames;  ///< the vertices of each

  std::size_t vertices() const { return frames.empty() ? 0 : frames[0].size(); }
  /// True if every coordinate is a number of single precision.
  bool IsSingle() const;
};

/// Reads a mesh for each frame, in the given order: PLY, OBJ or OFF, whose vertices have an order.
/// Each must have the vertices and triangles of the first.
MeshSequence ReadSequence(std::span<const std::filesystem::path> files);

/// Rejects a sequence without triangles, triangles that have a vertex twice or one that does not
/// exist, frames of other sizes, and coordinates that are not finite. `name`: for messages.
void CheckSequence(const MeshSequence& sequence, std::string_view name);

/// 64 hex digits: the hash of triangles and positions.
std::string Sha256(const MeshSequence& sequence);

}  // namespace cdb::deforming
