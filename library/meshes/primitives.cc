#include "library/meshes/primitives.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostCorners = 4096;

void CheckTorus(double major, double minor, std::size_t around, std::size_t across) {
  if (!(minor > 0 && minor < major && major <= kLargestCoordinate))
    throw library::SceneError(
        fmt::format("torus: the tube's radius {} must be above 0 and below the ring's radius {}",
                    minor, major));
  for (const std::size_t corners : {around, across})
    if (corners < 3 || corners > kMostCorners)
      throw library::SceneError(
          fmt::format("torus: {} corners round; 3 to {} are possible", corners, kMostCorners));
}

double Angle(std::size_t i, std::size_t of) {
  return 2 * std::numbers::pi * static_cast<double>(i % of) / static_cast<double>(of);
}

Vector3d OnTorus(double major, double minor, double around, double across) {
  const double from_axis = major + minor * std::cos(across);
  return {from_axis * std::cos(around), minor * std::sin(across), from_axis * std::sin(around)};
}

}  // namespace

Mesh TorusMesh(double major, double minor, std::size_t around, std::size_t across) {
  CheckTorus(major, minor, around, across);
  Mesh mesh;
  for (std::size_t i = 0; i < around; ++i)
    for (std::size_t k = 0; k < across; ++k)
      mesh.vertices.push_back(OnTorus(major, minor, Angle(i, around), Angle(k, across)));
  const auto at = [&](std::size_t i, std::size_t k) {
    return static_cast<std::uint32_t>(i % around * across + k % across);
  };
  for (std::size_t i = 0; i < around; ++i)
    for (std::size_t k = 0; k < across; ++k) {
      mesh.triangles.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1)});
      mesh.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i + 1, k)});
    }
  return mesh;
}

Mesh TetrahedronMesh(double edge) {
  if (!(edge > 0 && edge <= kLargestCoordinate))
    throw library::SceneError(fmt::format("tetrahedron: its edge {} must be above 0", edge));
  const double below = edge / std::sqrt(24.0);  // from the centre down to the base
  const double out = edge / std::sqrt(3.0);     // from the middle of the base to its corners
  Mesh mesh;
  mesh.vertices = {{0, 3 * below, 0},
                   {out, -below, 0},
                   {-out / 2, -below, edge / 2},
                   {-out / 2, -below, -edge / 2}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
  return mesh;
}

Decomposition TorusHulls(double major, double minor, std::size_t segments) {
  CheckTorus(major, minor, segments, kTorusCorners);
  std::vector<Hull> hulls(segments);
  for (std::size_t i = 0; i < segments; ++i)
    for (const std::size_t end : {i, i + 1})
      for (std::size_t k = 0; k < kTorusCorners; ++k)
        hulls[i].vertices.push_back(
            OnTorus(major, minor, Angle(end, segments), Angle(k, kTorusCorners)));
  return Assessed(std::move(hulls), TorusMesh(major, minor, kTorusFineness, kTorusFineness));
}

}  // namespace cdb::meshes
