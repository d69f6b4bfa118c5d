#include "library/meshes/mass_properties.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "library/meshes/primitives.h"
#include "library/objects/solid.h"
#include "tests/library/meshes/test_meshes.h"

namespace cdb::tests {
namespace {

using namespace testing;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

void ExpectNear(const meshes::MassProperties& got, double volume, const Vector3d& centre,
                const Matrix3d& inertia, double relative) {
  const double size = std::cbrt(volume);
  EXPECT_NEAR(got.volume, volume, relative * volume);
  EXPECT_LE((got.centre - centre).norm(), relative * size);
  EXPECT_LE((got.inertia - inertia).norm(), relative * inertia.norm()) << got.inertia << "\n\n"
                                                                       << inertia;
}

Matrix3d Diagonal(double x, double y, double z) { return Vector3d(x, y, z).asDiagonal(); }

TEST(MassProperties, BoxInClosedForm) {
  ExpectNear(meshes::MassPropertiesOf(BoxMesh({1, 2, 3}, {2, 4, 6})), 6, {1.5, 3, 4.5},
             Diagonal(4 + 9, 1 + 9, 1 + 4) / 12, 1e-14);
}

TEST(MassProperties, TetrahedronInClosedForm) {
  const double edge = 1.7;
  ExpectNear(meshes::MassPropertiesOf(meshes::TetrahedronMesh(edge)),
             std::pow(edge, 3) / (6 * std::sqrt(2.0)), Vector3d::Zero(),
             Diagonal(1, 1, 1) * edge * edge / 20, 1e-14);
  // A tetrahedron with a right-angled corner: the integrals of x and x y over the corner of a unit
  // cube.
  meshes::Mesh corner;
  corner.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  corner.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
  Matrix3d inertia = Matrix3d::Constant(1.0 / 80);
  inertia.diagonal().setConstant(3.0 / 40);
  ExpectNear(meshes::MassPropertiesOf(corner), 1.0 / 6, Vector3d::Constant(0.25), inertia, 1e-14);
}

TEST(MassProperties, TwoBoxesAddUp) {
  const meshes::MassProperties angle = meshes::MassPropertiesOf(AngleMesh());
  // A box 2 x 1 x 1 and a cube, by the parallel axis theorem.
  const Vector3d centre = (2 * Vector3d(1, 0.5, 0.5) + Vector3d(0.5, 1.5, 0.5)) / 3;
  const auto about = [&](const Vector3d& at, double mass, const Matrix3d& own) {
    const Vector3d d = at - centre;
    return Matrix3d(mass * (own + d.squaredNorm() * Matrix3d::Identity() - d * d.transpose()));
  };
  const Matrix3d inertia = (about({1, 0.5, 0.5}, 2, Diagonal(2, 5, 5) / 12) +
                            about({0.5, 1.5, 0.5}, 1, Diagonal(2, 2, 2) / 12)) /
                           3;
  ExpectNear(angle, 3, centre, inertia, 1e-14);
}

TEST(MassProperties, SphereConvergesAtSecondOrder) {
  const double radius = 1.3;
  double error = 0;
  for (int halvings = 2; halvings <= 6; ++halvings) {
    const meshes::MassProperties p = meshes::MassPropertiesOf(SphereMesh(radius, halvings));
    // Halving the edges quarters the error.
    const double next = 4 * kPi / 3 * std::pow(radius, 3) - p.volume;
    if (halvings > 2) {
      EXPECT_NEAR(error / next, 4, 0.25) << halvings;
    }
    error = next;
  }
  const meshes::MassProperties fine = meshes::MassPropertiesOf(SphereMesh(radius, 6));
  const objects::Solid ball{objects::Shape::kEllipsoid, Vector3d::Constant(2 * radius)};
  ExpectNear(fine, ball.Volume(), Vector3d::Zero(), ball.InertiaPerMass().asDiagonal(), 1e-3);
}

TEST(MassProperties, TorusConvergesAtSecondOrder) {
  const double R = 2, r = 0.5;
  const double volume = 2 * kPi * kPi * R * r * r;
  const double about_axis = R * R + 0.75 * r * r, across = R * R / 2 + 0.625 * r * r;
  double error = 0;
  for (std::size_t corners = 16; corners <= 256; corners *= 2) {
    const meshes::MassProperties p =
        meshes::MassPropertiesOf(meshes::TorusMesh(R, r, corners, corners));
    if (corners > 16) {
      EXPECT_NEAR(error / (volume - p.volume), 4, 0.1) << corners;
    }
    error = volume - p.volume;
    EXPECT_GT(error, 0);
  }
  ExpectNear(meshes::MassPropertiesOf(meshes::TorusMesh(R, r, 256, 256)), volume, Vector3d::Zero(),
             Diagonal(across, about_axis, across), 1e-3);
}

TEST(MassProperties, FollowRotationAndScale) {
  const Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Vector3d by(10, -20, 30);
  const meshes::MassProperties still = meshes::MassPropertiesOf(AngleMesh());
  const meshes::MassProperties moved = meshes::MassPropertiesOf(Moved(AngleMesh(), 2 * turn, by));
  ExpectNear(moved, 8 * still.volume, 2 * turn * still.centre + by,
             4 * turn * still.inertia * turn.transpose(), 1e-13);
  // The principal axes undo the rotation.
  const meshes::PrincipalAxes axes = meshes::PrincipalAxesOf(moved.inertia);
  EXPECT_NEAR(axes.rotation.determinant(), 1, 1e-14);
  EXPECT_LE((axes.rotation * axes.moments.asDiagonal() * axes.rotation.transpose() - moved.inertia)
                .norm(),
            1e-14 * moved.inertia.norm());
  // For the L, one axis is z, the others are the diagonals, and the moments are those of the closed
  // form.
  const meshes::PrincipalAxes own = meshes::PrincipalAxesOf(still.inertia);
  EXPECT_NEAR(std::abs(own.rotation(2, 2)), 1, 1e-14);
  EXPECT_NEAR(std::abs(own.rotation(0, 0)), std::sqrt(0.5), 1e-12);
}

TEST(MassProperties, PrincipalAxesOfRoundSolidsAreTheirOwn) {
  for (const meshes::Mesh& mesh :
       {BoxMesh({-1, -1, -1}, {1, 1, 1}), meshes::TorusMesh(2, 0.5, 24, 12), SphereMesh(1, 3),
        BoxMesh({-1, -2, -3}, {1, 2, 3})})
    EXPECT_EQ(meshes::PrincipalAxesOf(meshes::MassPropertiesOf(mesh).inertia).rotation,
              Matrix3d::Identity());
}

}  // namespace
}  // namespace cdb::tests
