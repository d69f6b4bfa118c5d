#include "library/meshes/mass_properties.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace cdb::meshes {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The common apex of all tetrahedra. Close to the mesh, so that large terms do not cancel.
Vector3d Apex(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return mesh.vertices.empty() ? Vector3d::Zero() : Vector3d(box.center());
}

}  // namespace

double SignedVolume(const Mesh& mesh) {
  const Vector3d apex = Apex(mesh);
  double six = 0;
  for (const Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = CornersOf(mesh, triangle);
    six += (a - apex).dot((b - apex).cross(c - apex));
  }
  return six / 6;
}

MassProperties MassPropertiesOf(const Mesh& mesh) {
  const Vector3d apex = Apex(mesh);
  double six_volumes = 0;
  Vector3d first = Vector3d::Zero();   // 24 times the integral of x
  Matrix3d second = Matrix3d::Zero();  // 120 times the integral of x x^T
  for (const Triangle& triangle : mesh.triangles) {
    const auto corners = CornersOf(mesh, triangle);
    const Vector3d a = corners[0] - apex, b = corners[1] - apex, c = corners[2] - apex;
    const double six = a.dot(b.cross(c));
    const Vector3d sum = a + b + c;
    six_volumes += six;
    first += six * sum;
    second +=
        six * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  MassProperties properties;
  properties.volume = six_volumes / 6;
  const Vector3d centre = first / 24 / properties.volume;
  properties.centre = apex + centre;
  const Matrix3d covariance = second / 120 / properties.volume - centre * centre.transpose();
  properties.inertia = covariance.trace() * Matrix3d::Identity() - covariance;
  return properties;
}

PrincipalAxes PrincipalAxesOf(const Matrix3d& inertia) {
  Matrix3d tensor = inertia;
  // Rounding must not choose the axes of a solid of revolution.
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      if (i != k && std::abs(tensor(i, k)) <= 1e-9 * inertia.trace()) tensor(i, k) = 0;
  if (tensor.isDiagonal(0)) return {tensor.diagonal(), Matrix3d::Identity()};
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(tensor);
  // The order and the signs of the axes are free: choose those closest to the axes of the mesh.
  std::array<int, 3> order{0, 1, 2}, best = order;
  double closest = -1;
  do {
    double along = 0;
    for (int i = 0; i < 3; ++i)
      along += std::abs(solver.eigenvectors()(i, order[static_cast<std::size_t>(i)]));
    if (along > closest) {
      closest = along;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  PrincipalAxes axes;
  for (int i = 0; i < 3; ++i) {
    const int from = best[static_cast<std::size_t>(i)];
    Vector3d axis = solver.eigenvectors().col(from);
    if (axis[i] < 0) axis = -axis;
    axes.rotation.col(i) = axis;
    axes.moments[i] = solver.eigenvalues()[from];
  }
  if (axes.rotation.determinant() < 0) axes.rotation.col(2) *= -1;
  return axes;
}

}  // namespace cdb::meshes
