#include "library/meshes/polygon.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "library/meshes/mass_properties.h"
#include "library/meshes/topology.h"
#include "tests/library/meshes/test_meshes.h"

namespace cdb::tests {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double Turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const Vector2d p = b - a, q = c - a;
  return p.x() * q.y() - p.y() * q.x();
}

std::vector<std::uint32_t> InOrder(std::size_t count) {
  std::vector<std::uint32_t> corners(count);
  for (std::uint32_t i = 0; i < count; ++i) corners[i] = i;
  return corners;
}

std::vector<meshes::Triangle> TrianglesOf(const std::vector<Vector2d>& polygon,
                                          const Eigen::Matrix3d& turn) {
  std::vector<Vector3d> vertices;
  for (const Vector2d& p : polygon) vertices.push_back(turn * Vector3d(p.x(), p.y(), 0.5));
  std::vector<meshes::Triangle> triangles;
  meshes::Triangulate(InOrder(polygon.size()), vertices, triangles);
  return triangles;
}

/// Whether the triangles cover the simple polygon once: all are counter-clockwise, and their areas
/// sum to its area.
void ExpectCovered(const std::vector<Vector2d>& polygon,
                   const std::vector<meshes::Triangle>& triangles) {
  ASSERT_EQ(triangles.size(), polygon.size() - 2);
  double area = 0, sum = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    area += Turn(polygon[0], polygon[i - 1], polygon[i]);
  for (const auto& [a, b, c] : triangles) {
    const double turn = Turn(polygon[a], polygon[b], polygon[c]);
    EXPECT_GE(turn, -1e-12 * area);
    sum += std::abs(turn);
  }
  EXPECT_NEAR(sum, area, 1e-9 * area);
}

TEST(Polygon, ConvexOnesAreFans) {
  EXPECT_EQ(TrianglesOf({{0, 0}, {2, 0}, {3, 1}, {0, 1}}, Eigen::Matrix3d::Identity()),
            (std::vector<meshes::Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Polygon, RandomSimpleOnesAreCoveredOnce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 300; ++round) {
    // Star-shaped about the origin, but with corners at any distance, so mostly not convex.
    const std::size_t count = 4 + random() % 60;
    std::vector<Vector2d> polygon;
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * (static_cast<double>(i) + unit(random) / 2) /
                           static_cast<double>(count);
      const double radius = 0.1 + unit(random);
      polygon.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(6 * unit(random), Vector3d::Random().normalized()).matrix();
    ExpectCovered(polygon, TrianglesOf(polygon, turn));
    // A comb, which is star-shaped about no point.
    std::vector<Vector2d> comb{{static_cast<double>(count), -1}, {static_cast<double>(count), 0}};
    for (std::size_t i = count; i-- > 0;) {
      comb.emplace_back(static_cast<double>(i) + 0.5, unit(random) * 5 + 0.1);
      comb.emplace_back(static_cast<double>(i), 0);
    }
    comb.emplace_back(0, -1);
    ExpectCovered(comb, TrianglesOf(comb, turn));
  }
}

/// A prism over a polygon given by its corners.
meshes::Mesh Prism(const std::vector<Vector2d>& points, const std::vector<std::uint32_t>& corners) {
  const auto count = static_cast<std::uint32_t>(points.size());
  meshes::Mesh mesh;
  for (const double z : {0.0, 1.0})
    for (const Vector2d& p : points) mesh.vertices.emplace_back(p.x(), p.y(), z);
  std::vector<std::uint32_t> top, bottom(corners.rbegin(), corners.rend());
  for (const std::uint32_t corner : corners) top.push_back(corner + count);
  meshes::Triangulate(top, mesh.vertices, mesh.triangles);
  meshes::Triangulate(bottom, mesh.vertices, mesh.triangles);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t a = corners[i], b = corners[(i + 1) % corners.size()];
    meshes::Triangulate(std::vector{a, b, b + count, a + count}, mesh.vertices, mesh.triangles);
  }
  return mesh;
}

TEST(Polygon, ARingStaysOpenInTheMiddle) {
  // The outer corners, a bridge to the inner ones, which go round the other way, and back.
  std::vector<Vector2d> points;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i <= 12; ++i) corners.push_back(i % 12);
  for (std::uint32_t i = 0; i <= 12; ++i) corners.push_back(12 + (12 - i) % 12);
  for (const double radius : {2.0, 1.0})
    for (int i = 0; i < 12; ++i)
      points.emplace_back(radius * std::cos(i * std::numbers::pi / 6),
                          radius * std::sin(i * std::numbers::pi / 6));
  const meshes::Mesh ring = meshes::Watertight(Prism(points, corners), "m");
  EXPECT_NEAR(meshes::SignedVolume(ring), 3 * 6 * 0.5, 1e-12);
  for (const meshes::Triangle& t : ring.triangles) {
    const auto [a, b, c] = meshes::CornersOf(ring, t);
    // Within the hole, or beyond it on the ring: no face has its centre inside the inner circle.
    EXPECT_GT(((a + b + c) / 3).head<2>().norm(), 0.9);
  }
}

TEST(Polygon, OnesThatCrossThemselvesStillCloseAMesh) {
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    std::vector<Vector2d> points;
    for (std::size_t i = 0; i < 4 + random() % 12; ++i)
      points.emplace_back(random() % 7, random() % 7);
    const meshes::Mesh prism = Prism(points, InOrder(points.size()));
    EXPECT_EQ(prism.triangles.size(), 4 * points.size() - 4);
    // Whatever its volume, no edge is open.
    try {
      meshes::Watertight(prism, "m");
    } catch (const library::SceneError& error) {
      EXPECT_EQ(std::string(error.what()).find("watertight"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace cdb::tests
