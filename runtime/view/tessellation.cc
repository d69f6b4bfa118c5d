#include "runtime/view/tessellation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace cdb::view {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using objects::Shape;

/// A point of a profile in the half plane x >= 0, with its normal.
struct ProfilePoint {
  double x, y, normal_x, normal_y;
};
/// A smooth section of a profile, from the bottom up.
using Profile = std::vector<ProfilePoint>;

void AddFace(TriangleMesh& mesh, const std::vector<Vector3d>& corners) {
  const Vector3d across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  if (!(across.norm() > 1e-12)) return;  // a degenerate triangle has no normal
  const Vector3d normal = across.normalized();
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vector3d& corner : corners) {
    mesh.positions.push_back(corner.cast<float>());
    mesh.normals.push_back(normal.cast<float>());
  }
  for (std::uint32_t i = 2; i < corners.size(); ++i)
    mesh.indices.insert(mesh.indices.end(), {first, first + i - 1, first + i});
}

/// Rotates the profile about y.
void AddSurface(TriangleMesh& mesh, const Profile& profile, int segments) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto n = static_cast<std::uint32_t>(segments);
  for (const ProfilePoint& point : profile)
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double angle = 2 * std::numbers::pi * (i % n) / n;
      const double c = std::cos(angle), s = std::sin(angle);
      mesh.positions.push_back(Vector3d(point.x * c, point.y, point.x * s).cast<float>());
      mesh.normals.push_back(
          Vector3d(point.normal_x * c, point.normal_y, point.normal_x * s).cast<float>());
    }
  for (std::uint32_t row = 0; row + 1 < profile.size(); ++row)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = first + row * (n + 1) + i, b = a + n + 1;
      if (profile[row].x > 0) mesh.indices.insert(mesh.indices.end(), {a, b, a + 1});
      if (profile[row + 1].x > 0) mesh.indices.insert(mesh.indices.end(), {a + 1, b, b + 1});
    }
}

/// The ball of diameter 1 between two latitudes, rad.
TriangleMesh BallMesh(const char* name, double from, double to, int segments) {
  TriangleMesh mesh{name, {}, {}, {}};
  const int rows = std::max(2, static_cast<int>(std::lround(segments * (to - from) / 6.28)));
  Profile profile;
  for (int i = 0; i <= rows; ++i) {
    const double latitude = from + (to - from) * i / rows;
    const bool is_pole = std::abs(latitude) > 1.5707;
    const double x = is_pole ? 0 : std::cos(latitude), y = std::sin(latitude);
    profile.push_back({x / 2, y / 2, x, y});
  }
  AddSurface(mesh, profile, segments);
  return mesh;
}

/// The cylinder in the cube of side 1 about the origin. `caps`: with both ends.
TriangleMesh CylinderMesh(const char* name, bool caps, int segments) {
  TriangleMesh mesh{name, {}, {}, {}};
  AddSurface(mesh, {{0.5, -0.5, 1, 0}, {0.5, 0.5, 1, 0}}, segments);
  if (!caps) return mesh;
  AddSurface(mesh, {{0, -0.5, 0, -1}, {0.5, -0.5, 0, -1}}, segments);
  AddSurface(mesh, {{0.5, 0.5, 0, 1}, {0, 0.5, 0, 1}}, segments);
  return mesh;
}

/// Height and diameter are 1, and the centre of mass is at the origin.
TriangleMesh ConeMesh(int segments) {
  TriangleMesh mesh{"cone", {}, {}, {}};
  const double slope = 1 / std::sqrt(5.0);  // the side rises by 2 per unit of radius
  AddSurface(mesh, {{0, -0.25, 0, -1}, {0.5, -0.25, 0, -1}}, segments);
  AddSurface(mesh, {{0.5, -0.25, 2 * slope, slope}, {0, 0.75, 2 * slope, slope}}, segments);
  return mesh;
}

TriangleMesh CuboidMesh() {
  TriangleMesh mesh{"cuboid", {}, {}, {}};
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-0.5, 0.5}) {
      const Vector3d out = sign * Vector3d::Unit(axis);
      const Vector3d u = 0.5 * Vector3d::Unit((axis + 1) % 3);
      const Vector3d v = 2 * sign * 0.5 * Vector3d::Unit((axis + 2) % 3);
      AddFace(mesh, {out - u - v, out + u - v, out + u + v, out - u + v});
    }
  return mesh;
}

TriangleMesh TetrahedronMesh() {
  TriangleMesh mesh{"tetrahedron", {}, {}, {}};
  const std::array<Vector3d, 4> corners = {Vector3d(0.5, 0.5, 0.5), Vector3d(0.5, -0.5, -0.5),
                                           Vector3d(-0.5, 0.5, -0.5), Vector3d(-0.5, -0.5, 0.5)};
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}})
    AddFace(mesh, {corners[static_cast<std::size_t>(a)], corners[static_cast<std::size_t>(b)],
                   corners[static_cast<std::size_t>(c)]});
  return mesh;
}

/// All convex pieces, or the triangles of a surface from both sides, in the axes of the model with
/// the centre of mass at the origin.
TriangleMesh CompoundMesh(const objects::ConvexDecomposition& form) {
  TriangleMesh mesh{form.name, {}, {}, {}};
  for (const objects::ConvexPiece& piece : form.pieces)
    for (const meshes::Triangle& face : piece.faces) {
      std::vector<Vector3d> corners;
      for (const auto corner : face)
        corners.push_back(piece.vertices[static_cast<std::size_t>(corner)] + piece.centre -
                          form.centre);
      AddFace(mesh, corners);
      if (!form.IsSurface()) continue;
      std::ranges::reverse(corners);
      AddFace(mesh, corners);
    }
  return mesh;
}

/// Their addresses are the keys of meshes that do not belong to a form.
constexpr char kShapeKeys[16] = {};
constexpr const void* kTubeKey = &kShapeKeys[12];
constexpr const void* kTopKey = &kShapeKeys[13];
constexpr const void* kBottomKey = &kShapeKeys[14];

}  // namespace

Tessellation::Tessellation(std::size_t bodies)
    : segments_(bodies > 2000  ? 12
                : bodies > 300 ? 20
                               : 36) {}

template <typename Make>
std::size_t Tessellation::MeshOf(const void* key, Make make) {
  const auto [found, is_new] = found_.emplace(key, meshes_.size());
  if (is_new) meshes_.push_back(make());
  return found->second;
}

std::vector<Part> Tessellation::CapsuleParts(const objects::Solid& solid) {
  constexpr double kRight = std::numbers::pi / 2;
  const double straight = solid.StraightHalf();
  const Vector3d caps(solid.sides.x(), solid.sides.y() - 2 * straight, solid.sides.z());
  const Vector3d tube(solid.sides.x(), 2 * straight, solid.sides.z());
  const auto none = Eigen::Quaterniond::Identity();
  return {{MeshOf(kTopKey, [&] { return BallMesh("capsule top", 0, kRight, segments_); }), caps,
           none, straight},
          {MeshOf(kBottomKey, [&] { return BallMesh("capsule bottom", -kRight, 0, segments_); }),
           caps, none, -straight},
          {MeshOf(kTubeKey, [&] { return CylinderMesh("capsule tube", false, segments_); }), tube,
           none, 0}};
}

Part Tessellation::CompoundPart(const objects::Solid& solid) {
  const objects::ConvexDecomposition& form = solid.compound->form();
  return {MeshOf(&form, [&] { return CompoundMesh(form); }), solid.compound->sides(),
          Eigen::Quaterniond(solid.compound->from_mesh()).normalized(), 0};
}

std::vector<Part> Tessellation::PartsOf(const objects::Solid& solid) {
  if (solid.shape == Shape::kCapsule && solid.StraightHalf() > 0) return CapsuleParts(solid);
  if (solid.shape == Shape::kCompound) return {CompoundPart(solid)};
  constexpr double kRight = std::numbers::pi / 2;
  // A capsule that is not higher than wide is an ellipsoid.
  const Shape shape = solid.shape == Shape::kCapsule ? Shape::kEllipsoid : solid.shape;
  const std::size_t mesh = MeshOf(&kShapeKeys[static_cast<std::size_t>(shape)], [&] {
    switch (shape) {
      case Shape::kCuboid:
        return CuboidMesh();
      case Shape::kCylinder:
        return CylinderMesh("cylinder", true, segments_);
      case Shape::kCone:
        return ConeMesh(segments_);
      case Shape::kTetrahedron:
        return TetrahedronMesh();
      case Shape::kEllipsoid:
      case Shape::kCapsule:
      case Shape::kCompound:
        break;
    }
    return BallMesh("sphere", -kRight, kRight, segments_);
  });
  return {{mesh, solid.sides, Eigen::Quaterniond::Identity(), 0}};
}

}  // namespace cdb::view
