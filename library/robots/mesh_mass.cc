#include "library/robots/mesh_mass.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "library/meshes/convex_hull.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/mesh.h"
#include "library/meshes/topology.h"
#include "library/scene_error.h"

namespace cdb::robots {

using analysis::RobotInertia;
using analysis::RobotShape;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using meshes::Mesh;

namespace {

/// As it is in the robot, along the axes of the shape.
Mesh ScaledMesh(const RobotShape& shape) {
  Mesh mesh = meshes::ReadMesh(shape.file);
  for (Vector3d& v : mesh.vertices) {
    if (shape.is_turned) v = Vector3d(v.x(), -v.z(), v.y());
    v = v.cwiseProduct(shape.sides);
  }
  if (shape.sides.prod() < 0)
    for (meshes::Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

RobotInertia OfSolid(const Mesh& mesh) {
  const meshes::MassProperties properties = meshes::MassPropertiesOf(mesh);
  return {properties.volume, properties.centre, properties.volume * properties.inertia};
}

using Corners = std::array<Vector3d, 3>;

double AreaOf(const Corners& c) { return (c[1] - c[0]).cross(c[2] - c[0]).norm() / 2; }

/// The integral of x x^T over the simplex of an apex at 0 and these corners (`share` 20), or over
/// the triangle itself (12), with this volume or area.
Matrix3d SecondMoment(const Corners& c, double weight, double share) {
  const Vector3d sum = c[0] + c[1] + c[2];
  Matrix3d products = sum * sum.transpose();
  for (const Vector3d& corner : c) products += corner * corner.transpose();
  return weight / share * products;
}

Matrix3d TensorOf(const Matrix3d& second) { return second.trace() * Matrix3d::Identity() - second; }

RobotInertia OfSurface(const Mesh& mesh, bool is_shell) {
  double area = 0;
  Vector3d mean = Vector3d::Zero();
  for (const meshes::Triangle& triangle : mesh.triangles) {
    const Corners c = meshes::CornersOf(mesh, triangle);
    area += AreaOf(c);
    mean += AreaOf(c) * (c[0] + c[1] + c[2]) / 3;
  }
  if (!(area > 0)) return {};
  mean /= area;
  const auto sum = [&](const Vector3d& apex, RobotInertia& whole) {
    Matrix3d second = Matrix3d::Zero();
    Vector3d first = Vector3d::Zero();
    whole.mass = 0;
    for (const meshes::Triangle& triangle : mesh.triangles) {
      Corners c = meshes::CornersOf(mesh, triangle);
      for (Vector3d& corner : c) corner -= apex;
      const double weight = is_shell ? AreaOf(c) : std::abs(c[0].dot(c[1].cross(c[2]))) / 6;
      whole.mass += weight;
      first += weight * (c[0] + c[1] + c[2]) / (is_shell ? 3 : 4);
      second += SecondMoment(c, weight, is_shell ? 12 : 20);
    }
    whole.tensor = TensorOf(second);
    return Vector3d(apex + first / whole.mass);
  };
  RobotInertia whole;
  whole.centre = sum(mean, whole);
  // As MuJoCo does: about that centre, whose tetrahedra have another volume.
  sum(whole.centre, whole);
  return whole;
}

}  // namespace

RobotInertia InertiaOfMesh(const RobotShape& shape, MeshMass rule) {
  const std::string name = shape.written;
  Mesh mesh = ScaledMesh(shape);
  if (mesh.triangles.empty()) rule = MeshMass::kHull;
  RobotInertia own;
  switch (rule) {
    case MeshMass::kSolid:
      own = OfSolid(meshes::Watertight(std::move(mesh), name));
      break;
    case MeshMass::kHull:
      own = OfSolid(meshes::SurfaceOf(meshes::ConvexHull(mesh, name)));
      break;
    case MeshMass::kShell:
    case MeshMass::kUnsigned:
      own = OfSurface(mesh, rule == MeshMass::kShell);
      break;
  }
  if (!(own.mass > 0) || !std::isfinite(own.mass))
    throw library::SceneError(
        fmt::format("{}: the mesh has no {}", name, rule == MeshMass::kShell ? "area" : "volume"),
        "write <inertial>");
  const Matrix3d turn = shape.pose.linear();
  return {own.mass, shape.pose * own.centre, turn * own.tensor * turn.transpose()};
}

}  // namespace cdb::robots
