#include "runtime/pages/view/tessellation.h"

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
using shapes::Profile;
using shapes::ProfilePoint;

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

TriangleMesh Turned(std::string name, const std::vector<Profile>& profiles, int segments) {
  TriangleMesh mesh{std::move(name), {}, {}, {}};
  for (const Profile& profile : profiles) AddSurface(mesh, profile, segments);
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
constexpr char kShapeKeys[objects::kClosedShapes.size()] = {}, kTubeKey[1] = {}, kTopKey[1] = {},
               kBottomKey[1] = {};

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
  const double straight = shapes::Capsule::StraightHalf(solid.sides);
  const Vector3d caps(solid.sides.x(), solid.sides.y() - 2 * straight, solid.sides.z());
  const Vector3d tube(solid.sides.x(), 2 * straight, solid.sides.z());
  const auto none = Eigen::Quaterniond::Identity();
  const auto cap = [&](const char* name, double from, double to) {
    return Turned(name, {shapes::Ellipsoid::Arc(from, to, segments_)}, segments_);
  };
  return {{MeshOf(kTopKey, [&] { return cap("capsule top", 0, kRight); }), caps, none, straight},
          {MeshOf(kBottomKey, [&] { return cap("capsule bottom", -kRight, 0); }), caps, none,
           -straight},
          {MeshOf(kTubeKey,
                  [&] { return Turned("capsule tube", {shapes::Cylinder::Side()}, segments_); }),
           tube, none, 0}};
}

Part Tessellation::CompoundPart(const objects::Solid& solid) {
  const objects::ConvexDecomposition& form = solid.compound->form();
  return {MeshOf(&form, [&] { return CompoundMesh(form); }), solid.compound->sides(),
          Eigen::Quaterniond(solid.compound->from_mesh()).normalized(), 0};
}

std::vector<Part> Tessellation::PartsOf(const objects::Solid& solid) {
  if (solid.compound) return {CompoundPart(solid)};
  if (solid.shape == Shape::kCapsule && shapes::Capsule::StraightHalf(solid.sides) > 0)
    return CapsuleParts(solid);
  // A capsule that is not higher than wide is an ellipsoid.
  const Shape shape = solid.shape == Shape::kCapsule ? Shape::kEllipsoid : solid.shape;
  const std::size_t mesh = MeshOf(&kShapeKeys[static_cast<std::size_t>(shape)], [&] {
    return objects::Visit(shape, [&](auto form) {
      const std::string name(form.kType.name());
      if constexpr (requires { form.Profiles(segments_); })
        return Turned(name, form.Profiles(segments_), segments_);
      TriangleMesh mesh_of_faces{name, {}, {}, {}};
      if constexpr (requires { form.Faces(); })
        for (const shapes::FlatFace& face : form.Faces()) AddFace(mesh_of_faces, face);
      return mesh_of_faces;
    });
  });
  return {{mesh, solid.sides, Eigen::Quaterniond::Identity(), 0}};
}

}  // namespace cdb::view
