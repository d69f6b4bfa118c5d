// Converts solids to triangles, for pages and glTF files.
//
// A body is drawn as one or several parts, each with a mesh that many bodies share: a sphere has
// the unit ball, scaled to the body's sides. Lengths in m. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "library/objects/solid.h"

namespace cdb::view {

/// Triangles, counter-clockwise from outside, with a unit normal for each vertex.
struct TriangleMesh {
  std::string name;  ///< `sphere`, `bunny`
  std::vector<Eigen::Vector3f> positions, normals;
  std::vector<std::uint32_t> indices;  ///< three for each triangle
};

/// A mesh placed in the body's frame: x becomes offset + rotation (scale x).
struct Part {
  std::size_t mesh = 0;  ///< index into Tessellation::meshes
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double offset_y = 0;  ///< the other coordinates are 0
};

class Tessellation {
 public:
  /// `bodies`: their expected number; with more bodies, round meshes are coarser. The vertices lie
  /// on the solid and reach at least 0.93 of its extent in every direction.
  explicit Tessellation(std::size_t bodies);

  /// A capsule has three parts, any other solid has one. The vertices of all parts are points of
  /// the surface; for a compound, of the surface of one of its convex pieces.
  std::vector<Part> PartsOf(const objects::Solid& solid);
  const std::vector<TriangleMesh>& meshes() const { return meshes_; }

 private:
  template <typename Make>
  std::size_t MeshOf(const void* key, Make make);
  std::vector<Part> CapsuleParts(const objects::Solid& solid);
  Part CompoundPart(const objects::Solid& solid);

  const int segments_;  ///< per full turn
  std::map<const void*, std::size_t> found_;
  std::vector<TriangleMesh> meshes_;
};

}  // namespace cdb::view
