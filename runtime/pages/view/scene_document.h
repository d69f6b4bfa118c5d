// The document that the page of `cdb view` draws: one or two runs as JSON.
//
// Arrays are base64. For each run: `meshes`; `parts` with a row of `place` (scale,
// rotation x y z w, offset along y) for each; `bodies`; `frames`: positions as float32,
// orientations as three words; `contacts` and `boxes`, null where they were not recorded; and the
// series of all cycles. runtime/pages/page/view/recording.js reads it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "library/objects/solid.h"
#include "runtime/pages/view/selection.h"

namespace cdb::view {

/// Always valid UTF-8, even if names are not.
std::string SceneDocument(const std::string& title, std::span<const SceneRecording> recordings);

// Packs numbers as text for a page: little-endian, in base64.

std::string Base64(std::span<const std::byte> bytes);
/// 4 bytes each; a value beyond float32 becomes infinite.
std::string PackFloats(std::span<const double> values);
std::string PackInts(std::span<const std::int32_t> values);
std::string PackShorts(std::span<const std::uint16_t> values);

/// A unit quaternion in 48 bits: three words of 15 bits for the components without the largest one,
/// in the order x y z w, each from -1/sqrt(2) to 1/sqrt(2). The top bits of the first two words
/// have the index of the largest component, that of the third has `flag`. The components are exact
/// to kQuaternionError. A quaternion that is not finite becomes the identity.
std::array<std::uint16_t, 3> PackQuaternion(const Eigen::Quaterniond& q, bool flag);
inline constexpr double kQuaternionError = 2.2e-5;

// Converts solids to triangles, for pages and glTF files.
//
// A body is drawn as one or several parts, each with a mesh that many bodies share: a sphere has
// the unit ball, scaled to the body's sides. Lengths in m. Not thread-safe.

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

/// Of the rows or columns of a height field, one in this number is drawn: a page with all of them
/// could be too large.
inline std::size_t HeightStep(std::size_t lines) { return (lines - 2) / 160 + 1; }

class Tessellation {
 public:
  /// `bodies`: their expected number; with more bodies, round meshes are coarser. The vertices lie
  /// on the solid and reach at least 0.93 of its extent in every direction. If there are many, the
  /// exponents of superellipsoids are drawn to a tenth.
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
  Part SuperellipsoidPart(const objects::Solid& solid);

  const int segments_;  ///< per full turn
  std::map<const void*, std::size_t> found_;
  std::map<std::pair<double, double>, std::size_t> superellipsoids_;  ///< by their exponents
  std::vector<TriangleMesh> meshes_;
};

}  // namespace cdb::view
