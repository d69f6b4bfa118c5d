// Normals of known corners of surfaces.
#include "library/exact/legal_normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "library/objects/surface.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using exact::NearestLegalNormal;

/// A surface whose box has its middle at the origin, so that points are those of the mesh.
objects::Compound SurfaceOf(const std::vector<Vector3d>& vertices,
                            const std::vector<meshes::Triangle>& triangles) {
  meshes::Mesh mesh;
  mesh.vertices = vertices;
  mesh.triangles = triangles;
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : vertices) box.extend(vertex);
  EXPECT_LT(box.center().norm(), 1e-12);
  auto form = std::make_shared<const objects::ConvexDecomposition>(objects::MakeSurface("s", mesh));
  return {form, form->proportions * box.sizes().maxCoeff()};
}

/// Two slopes that meet on the z axis, `rise` high: a ridge, or a valley if it is negative.
objects::Compound Roof(double rise) {
  const double y = rise / 2;
  return SurfaceOf({{-1, -y, -1}, {0, y, -1}, {1, -y, -1}, {-1, -y, 1}, {0, y, 1}, {1, -y, 1}},
                   {{0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}});
}

/// The angle to the nearest legal normal, rad.
double AngleAt(const objects::Compound& surface, const Vector3d& point, const Vector3d& normal) {
  const auto legal = NearestLegalNormal(surface, point, normal.normalized(), 1e-3);
  EXPECT_TRUE(legal);
  if (!legal) return -1;
  EXPECT_NEAR(legal->norm(), 1, 1e-12);
  return std::atan2(legal->cross(normal.normalized()).norm(), legal->dot(normal.normalized()));
}

TEST(LegalNormals, AFaceHasItsOwnOnBothSides) {
  const objects::Compound roof = Roof(1);
  const Vector3d right = Vector3d(1, 1, 0).normalized(), point(0.5, 0, 0.2);
  EXPECT_LT(AngleAt(roof, point, right), 1e-9);
  EXPECT_LT(AngleAt(roof, point, -right), 1e-9);
  EXPECT_NEAR(AngleAt(roof, point, Vector3d(0, 1, 0)), M_PI / 4, 1e-9);
}

TEST(LegalNormals, ACoplanarEdgeHasThoseOfItsFaces) {
  const objects::Compound roof = Roof(1);
  // On the diagonal of the right slope, from (0, .5, -1) to (1, -.5, 1).
  const Vector3d middle(0.5, 0, 0), right = Vector3d(1, 1, 0).normalized();
  EXPECT_LT(AngleAt(roof, middle, right), 1e-9);
  EXPECT_NEAR(AngleAt(roof, middle, right + 0.1 * Vector3d(1, -1, 0)),
              std::atan(0.1 * std::sqrt(2)), 1e-9);
}

TEST(LegalNormals, ARidgeHasThoseBetweenItsFacesAndAValleyDoesNot) {
  const Vector3d left = Vector3d(-1, 1, 0).normalized(), right = Vector3d(1, 1, 0).normalized();
  for (const double rise : {1.0, -1.0}) {
    const objects::Compound roof = Roof(rise);
    const Vector3d top(0, rise / 2, 0.3);
    EXPECT_LT(AngleAt(roof, top, left), 1e-9);
    EXPECT_LT(AngleAt(roof, top, right), 1e-9);
    for (const double x : {-0.7, 0.0, 0.4}) {
      const double angle = AngleAt(roof, top, Vector3d(x, 1, 0));
      // In a valley, the faces' own are nearest; from below, it is a ridge.
      EXPECT_NEAR(angle, rise > 0 ? 0 : M_PI / 4 - std::abs(std::atan(x)), 1e-9) << x;
      EXPECT_NEAR(AngleAt(roof, top, Vector3d(x, -1, 0)),
                  rise < 0 ? 0 : angle + M_PI / 4 - std::abs(std::atan(x)), 1e-9);
    }
    // Beyond the faces, and along the edge.
    EXPECT_NEAR(AngleAt(roof, top, Vector3d(2, 1, 0)), std::atan(2) - M_PI / 4, 1e-9);
    EXPECT_NEAR(AngleAt(roof, top, Vector3d(1, 1, 1)), std::asin(1 / std::sqrt(3)), 1e-9);
  }
}

TEST(LegalNormals, AnOpenEdgeHasAHalfCircle) {
  const objects::Compound roof = Roof(1);
  const Vector3d rim(1, -0.5, 0.3), down = Vector3d(1, -1, 0).normalized();
  for (const double turn : {-1.5, -0.4, 0.8, 1.5}) {
    const Vector3d normal = std::cos(turn) * down + std::sin(turn) * Vector3d(1, 1, 0).normalized();
    EXPECT_LT(AngleAt(roof, rim, normal), 1e-9) << turn;
  }
  EXPECT_GT(AngleAt(roof, rim, Vector3d(0, 1, 0)), 0.7) << "towards the roof";
}

TEST(LegalNormals, AConvexCornerHasACone) {
  // The corner of a cube, at (1, 1, 1) / 2, from its three faces there.
  const objects::Compound cube = SurfaceOf(
      {{1, 1, 1}, {-1, 1, 1}, {-1, 1, -1}, {1, 1, -1}, {1, -1, 1}, {1, -1, -1}, {-1, -1, 1}},
      {{0, 3, 2}, {0, 2, 1}, {0, 4, 5}, {0, 5, 3}, {0, 1, 6}, {0, 6, 4}});
  const Vector3d corner(1, 1, 1);
  EXPECT_LT(AngleAt(cube, corner, Vector3d(1, 1, 1)), 1e-9);
  EXPECT_LT(AngleAt(cube, corner, Vector3d(0.1, 1, 0.3)), 1e-9);
  EXPECT_LT(AngleAt(cube, corner, Vector3d(0, 1, 0.3)), 1e-9);
  EXPECT_NEAR(AngleAt(cube, corner, Vector3d(-0.3, 1, 0)), std::atan(0.3), 1e-9);
  // On an edge away from the corner, nothing along the edge.
  EXPECT_NEAR(AngleAt(cube, Vector3d(0, 1, 1), Vector3d(1, 1, 1)), std::asin(1 / std::sqrt(3)),
              1e-9);
}

TEST(LegalNormals, TrianglesMeetByPosition) {
  const Vector3d sideways(1, 1, 0);
  // Unwelded, and with a vertex of two triangles in the middle of the third one's edge.
  const objects::Compound unwelded =
      SurfaceOf({{-1, 0, -1}, {-1, 0, 1}, {1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {1, 0, 1}},
                {{0, 1, 2}, {3, 4, 5}});
  EXPECT_NEAR(AngleAt(unwelded, Vector3d::Zero(), sideways), M_PI / 4, 1e-9);
  const objects::Compound split =
      SurfaceOf({{-1, 0, -1}, {-1, 0, 1}, {1, 0, -1}, {0, 0, 0}, {1, 0, 1}},
                {{0, 1, 2}, {2, 3, 4}, {3, 1, 4}});
  EXPECT_NEAR(AngleAt(split, Vector3d(0.3, 0, -0.3), sideways), M_PI / 4, 1e-9);
  EXPECT_NEAR(AngleAt(split, Vector3d(0, 0, 0), sideways), M_PI / 4, 1e-9);
}

TEST(LegalNormals, AwayFromTheSurfaceThereAreNone) {
  EXPECT_FALSE(NearestLegalNormal(Roof(1), Vector3d(0, 0.6, 0), Vector3d(0, 1, 0), 0.05));
  EXPECT_TRUE(NearestLegalNormal(Roof(1), Vector3d(0, 0.6, 0), Vector3d(0, 1, 0), 0.15));
}

/// An axis-aligned box.
exact::Region Tile(const Vector3d& low, const Vector3d& high) {
  return
      [box = Eigen::AlignedBox3d(low, high)](const Vector3d& point) { return box.contains(point); };
}

/// The nearest legal normal beside `others`; zero if there is none.
Vector3d BesideTiles(const exact::Region& own, const exact::Region& others, const Vector3d& point,
                     const Vector3d& normal) {
  // In any axes: turned as a whole, the result turns too.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vector3d(0.3, -0.8, 0.5).normalized()));
  const auto turned = [&](const exact::Region& region) -> exact::Region {
    return [&turn, region](const Vector3d& place) { return region(turn.conjugate() * place); };
  };
  const auto legal = NearestLegalNormal(turned(own), turned(others), turn * point,
                                        turn * normal.normalized(), 2e-3, 1e-3);
  EXPECT_TRUE(legal);
  return legal ? turn.conjugate() * *legal : Vector3d::Zero();
}

constexpr double kCoarse = 0.03;

TEST(LegalNormalsOfSolids, TilesHaveOnlyTheNormalOfTheFloorWhereTheyMeet) {
  const Vector3d up(0, 1, 0), aside(1, 0, 0);
  const exact::Region left = Tile({-1, -1, -1}, {0, 0, 1});
  // Beside it: of the same size, larger, one of several, below another one.
  for (const exact::Region& right :
       {Tile({0, -1, -1}, {1, 0, 1}), Tile({0, -3, -5}, {7, 0, 4}),
        Tile({1e-9, -1, -1}, {1, -1e-9, 1}), Tile({-1e-6, -1, -1}, {1, 0, 1})}) {
    for (const double z : {-0.7, 0.0, 0.9}) {
      EXPECT_LT((BesideTiles(left, right, {0, 0, z}, up) - up).norm(), 1e-9);
      EXPECT_LT(BesideTiles(left, right, {0, 0, z}, aside).norm(), kCoarse);
      EXPECT_LT(BesideTiles(left, right, {0, -0.001, z}, aside).norm(), kCoarse);
      EXPECT_LT((BesideTiles(left, right, {0, 0, z}, {1, 1, 0}) - up).norm(), 3 * kCoarse);
      EXPECT_LT((BesideTiles(left, right, {0, 0, z}, {0.3, 1, 0}) - up).norm(), 3 * kCoarse);
    }
  }
}

TEST(LegalNormalsOfSolids, AStepHasTheNormalsOfItsSide) {
  const Vector3d up(0, 1, 0), aside(1, 0, 0), between(1, 1, 0);
  const exact::Region high = Tile({-1, -1, -1}, {0, 0, 1});
  for (const double step : {0.01, 0.3}) {
    const exact::Region low = Tile({0, -1, -1}, {1, -step, 1});
    EXPECT_EQ(BesideTiles(high, low, {0, 0, 0.2}, up).dot(up) > 1 - 1e-9, true);
    EXPECT_GT(BesideTiles(high, low, {0, -step / 2, 0.2}, aside).dot(aside), 1 - 1e-9);
    EXPECT_GT(BesideTiles(high, low, {0, 0, 0.2}, between).dot(between.normalized()), 1 - 1e-9);
    // On the lower one, at the foot of the step.
    EXPECT_GT(BesideTiles(low, high, {0, -step, 0.2}, up).dot(up), 1 - 1e-9);
  }
}

TEST(LegalNormalsOfSolids, ACornerOfAWallHasThoseOfBothSides) {
  const Vector3d up(0, 1, 0), aside(-1, 0, 0);
  const exact::Region floor = Tile({-1, -1, -1}, {1, 0, 1}), wall = Tile({0.5, 0, -1}, {1, 2, 1});
  EXPECT_GT(BesideTiles(floor, wall, {0.5, 0, 0}, up).dot(up), 1 - 1e-9);
  EXPECT_GT(BesideTiles(wall, floor, {0.5, 0, 0}, aside).dot(aside), 1 - 1e-9);
  // Below the wall, the floor has no surface.
  EXPECT_LT(BesideTiles(floor, wall, {0.8, 0, 0}, up).norm(), kCoarse);
}

TEST(LegalNormalsOfSolids, APointInTheAirHasNone) {
  EXPECT_FALSE(NearestLegalNormal(Tile({-1, -1, -1}, {0, 0, 1}), Tile({0, -1, -1}, {1, 0, 1}),
                                  {0, 0.1, 0}, {0, 1, 0}, 2e-3, 1e-3));
}

}  // namespace
}  // namespace cdb::tests
