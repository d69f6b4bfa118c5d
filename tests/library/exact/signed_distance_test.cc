// The referee against closed forms, written here.
#include "library/exact/signed_distance.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "library/objects/surface.h"
#include "tests/library/objects/random_solids.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using exact::DistanceOf;
using exact::SignedDistance;
using objects::Pose;
using objects::Shape;
using objects::Solid;

Solid Ball(double size) { return {Shape::kEllipsoid, Vector3d::Constant(size)}; }
Solid Box(double x, double y, double z) { return {Shape::kCuboid, {x, y, z}}; }
Pose PoseAt(double x, double y, double z) { return {Vector3d(x, y, z)}; }

/// 1e-11 of the smaller body is what the referee claims.
void ExpectNear(const SignedDistance& distance, double exact, double size = 1) {
  EXPECT_NEAR(distance.lower, exact, 2e-11 * size);
  EXPECT_NEAR(distance.upper, exact, 2e-11 * size);
}

Vector3d NearestOnSegment(const Vector3d& a, const Vector3d& b, const Vector3d& point) {
  const double at = (point - a).dot(b - a) / (b - a).squaredNorm();
  return a + std::clamp(at, 0.0, 1.0) * (b - a);
}

/// The signed distance of a point from a figure of revolution about y, given by the corners of a
/// convex polygon in its half plane, counter-clockwise, that begins and ends on the axis.
double FromRevolved(const std::vector<Vector3d>& outline, const Vector3d& point) {
  const Vector3d p(std::hypot(point.x(), point.z()), point.y(), 0);
  double distance = INFINITY;
  bool is_inside = true;
  for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
    distance = std::min(distance, (NearestOnSegment(outline[i], outline[i + 1], p) - p).norm());
    const Vector3d along = outline[i + 1] - outline[i];
    is_inside =
        is_inside && along.x() * (p - outline[i]).y() - along.y() * (p - outline[i]).x() > 0;
  }
  return is_inside ? -distance : distance;
}

TEST(SignedDistance, OfABallAndAFigureOfRevolutionIsThatOfItsCentre) {
  distributions::Stream stream(1);
  for (int i = 0; i < Cases(1000); ++i) {
    const double radius = stream.LogUniform(0.1, 2), height = stream.LogUniform(0.1, 2);
    const Solid ball = Ball(stream.LogUniform(0.1, 2));
    Solid solid{i % 3 == 0   ? Shape::kCylinder
                : i % 3 == 1 ? Shape::kCone
                             : Shape::kCapsule,
                {2 * radius, height, 2 * radius}};
    std::vector<Vector3d> outline;
    double around = 0;
    if (i % 3 == 0) {
      outline = {{0, -height / 2, 0},
                 {radius, -height / 2, 0},
                 {radius, height / 2, 0},
                 {0, height / 2, 0}};
    } else if (i % 3 == 1) {
      outline = {{0, -height / 4, 0}, {radius, -height / 4, 0}, {0, 0.75 * height, 0}};
    } else {
      solid.sides.y() += 2 * radius;
      outline = {{0, -height / 2, 0}, {0, height / 2, 0}};
      around = radius;
    }
    const Pose pose{RandomDirection(stream), stream.Turn()};
    const Vector3d centre = RandomDirection(stream) * stream.Uniform(0.01, 2);
    const Pose at{pose.position + pose.orientation * centre, stream.Turn()};
    const double core = i % 3 == 2
                            ? (NearestOnSegment(outline[0], outline[1], centre) - centre).norm()
                            : FromRevolved(outline, centre);
    ExpectNear(DistanceOf(ball, at, solid, pose), core - ball.sides.x() / 2 - around, 3);
  }
}

TEST(SignedDistance, OfTwoRoundCapsulesIsThatOfTheirSegments) {
  distributions::Stream stream(2);
  for (int i = 0; i < Cases(1000); ++i) {
    struct Capsule {
      Solid solid;
      Pose pose;
      Vector3d ends[2];
    } both[2];
    double radii = 0;
    for (Capsule& one : both) {
      const double radius = stream.LogUniform(0.1, 1), half = stream.LogUniform(0.1, 2);
      one.solid = {Shape::kCapsule, {2 * radius, 2 * (half + radius), 2 * radius}};
      one.pose = {RandomDirection(stream) * stream.Uniform(0, 2), stream.Turn()};
      for (int end = 0; end < 2; ++end)
        one.ends[end] =
            one.pose.position + one.pose.orientation * Vector3d(0, end == 0 ? -half : half, 0);
      radii += radius;
    }
    // The distance of two segments is that of an end from the other, or of the two lines.
    const auto& [a, b] = both;
    double between = INFINITY;
    for (int end = 0; end < 2; ++end) {
      between = std::min(
          between, (NearestOnSegment(a.ends[0], a.ends[1], b.ends[end]) - b.ends[end]).norm());
      between = std::min(
          between, (NearestOnSegment(b.ends[0], b.ends[1], a.ends[end]) - a.ends[end]).norm());
    }
    const Vector3d u = a.ends[1] - a.ends[0], v = b.ends[1] - b.ends[0], w = b.ends[0] - a.ends[0];
    const Vector3d across = u.cross(v);
    const double s = w.cross(v).dot(across) / across.squaredNorm(),
                 t = w.cross(u).dot(across) / across.squaredNorm();
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1)
      between = std::min(between, std::fabs(w.dot(across.normalized())));
    ExpectNear(DistanceOf(a.solid, a.pose, b.solid, b.pose), between - radii, 2);
  }
}

using Wide = Eigen::Matrix<long double, 3, 1>;

struct Polytope {
  std::vector<Wide> corners, normals, edges;
};

Polytope PolytopeOf(const Solid& solid, const Pose& pose) {
  const Eigen::Matrix<long double, 3, 3> turn =
      pose.orientation.cast<long double>().normalized().toRotationMatrix();
  const Wide half = solid.HalfExtents().cast<long double>();
  Polytope it;
  if (solid.shape == Shape::kCuboid) {
    for (int corner = 0; corner < 8; ++corner)
      it.corners.push_back(Wide(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1));
    for (int axis = 0; axis < 3; ++axis) it.edges.push_back(Wide::Unit(axis));
    it.normals = it.edges;
  } else {
    it.corners = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) it.edges.push_back(it.corners[i] - it.corners[j]);
  }
  for (auto* list : {&it.corners, &it.edges})
    for (Wide& one : *list) one = turn * one.cwiseProduct(half);
  for (Wide& normal : it.normals) normal = turn * normal;
  if (it.normals.empty())
    for (std::size_t out = 0; out < 4; ++out) {
      const auto corner = [&](std::size_t i) { return it.corners[(out + i) % 4]; };
      it.normals.push_back((corner(2) - corner(1)).cross(corner(3) - corner(1)));
    }
  for (Wide& corner : it.corners) corner += pose.position.cast<long double>();
  return it;
}

/// The largest gap along any normal of a face and any product of two edges.
long double SeparationOf(const Polytope& a, const Polytope& b) {
  long double most = -INFINITY;
  const auto consider = [&](const Wide& axis) {
    if (!(axis.norm() > 1e-9L)) return;
    for (const long double sign : {1.0L, -1.0L}) {
      const Wide normal = sign * axis.normalized();
      long double low = INFINITY, high = -INFINITY;
      for (const Wide& corner : a.corners) low = std::min(low, normal.dot(corner));
      for (const Wide& corner : b.corners) high = std::max(high, normal.dot(corner));
      most = std::max(most, low - high);
    }
  };
  for (const Polytope* one : {&a, &b})
    for (const Wide& normal : one->normals) consider(normal);
  for (const Wide& u : a.edges)
    for (const Wide& v : b.edges) consider(u.cross(v));
  return most;
}

TEST(SignedDistance, OfOverlappingPolytopesIsThatOfAnAxis) {
  distributions::Stream stream(3);
  int overlapping = 0;
  for (int i = 0; i < Cases(1000); ++i) {
    const auto draw = [&] {
      return RandomSolid(stream, stream.Uniform() < 0.6 ? Shape::kCuboid : Shape::kTetrahedron,
                         i % 4 == 0 ? 1000 : 4);
    };
    const Solid a = draw(), b = draw();
    const Pose pose_a{RandomDirection(stream) * stream.Uniform(0, 2), stream.Turn()},
        pose_b{RandomDirection(stream), stream.Turn()};
    const auto exact =
        static_cast<double>(SeparationOf(PolytopeOf(a, pose_a), PolytopeOf(b, pose_b)));
    const SignedDistance distance = DistanceOf(a, pose_a, b, pose_b);
    if (exact > 0) {
      EXPECT_GE(distance.upper, exact);
      continue;
    }
    ++overlapping;
    ExpectNear(distance, exact, std::max(a.OuterRadius(), b.OuterRadius()));
  }
  EXPECT_GT(overlapping, Cases(300));
}

TEST(SignedDistance, IsExactWhereBodiesTouch) {
  const Solid cube = Box(1, 1, 1), cylinder{Shape::kCylinder, {1, 1, 1}},
              cone{Shape::kCone, {1, 1, 1}}, capsule{Shape::kCapsule, {1, 3, 1}};
  ExpectNear(DistanceOf(cube, PoseAt(0, 1, 0), cube, {}), 0);
  ExpectNear(DistanceOf(cube, PoseAt(0, 1, 1), cube, {}), 0);
  ExpectNear(DistanceOf(cube, PoseAt(1, 1, 1), cube, {}), 0);
  ExpectNear(DistanceOf(cube, PoseAt(0, 1.25, 0), cone, {}), 0);
  ExpectNear(DistanceOf(cylinder, PoseAt(0, 1, 0), cylinder, {}), 0);
  ExpectNear(DistanceOf(cylinder, PoseAt(0, 0.999, 0), cylinder, {}), -0.001);
  ExpectNear(DistanceOf(capsule, PoseAt(0, 3, 0), capsule, {}), 0);
  ExpectNear(DistanceOf(Ball(1), PoseAt(1, 0, 0), cylinder, {}), 0);
  ExpectNear(DistanceOf(Ball(1), PoseAt(0, 1.25, 0), cone, {}), 0);
}

TEST(SignedDistance, SeesAShallowOverlapWithTheRimOfACylinder) {
  // .061 mm along the diagonal from the rim: Bullet, which rounds the rim, makes no contact.
  const Solid ball = Ball(0.1), cylinder{Shape::kCylinder, {0.27, 0.27, 0.27}};
  const double away = (0.05 - 0.061e-3) / std::sqrt(2.0);
  ExpectNear(DistanceOf(ball, PoseAt(0.135 + away, 0.135 + away, 0), cylinder, {}), -0.061e-3);
}

TEST(SignedDistance, OfBodiesAboutOneAxisIsNearlyAsTight) {
  // All directions in a plane are equally good.
  const Solid cylinder{Shape::kCylinder, {1, 3, 1}}, cone{Shape::kCone, {1, 3, 1}};
  const auto expect = [](const SignedDistance& distance, double depth) {
    EXPECT_NEAR(distance.Depth(), depth, 1e-12);
    EXPECT_LE(distance.lower, -depth);
    EXPECT_GE(distance.upper, -depth);
    EXPECT_LE(distance.upper - distance.lower, 1e-6);
  };
  expect(DistanceOf(Ball(0.2), {}, cylinder, {}), 0.6);
  expect(DistanceOf(Ball(0.2), PoseAt(0, 0.15, 0), cone, {}),
         0.1 + 2.1 / 3 / std::hypot(2, 1.0 / 3));
  expect(DistanceOf(cylinder, {}, cylinder, {}), 1);
}

TEST(SignedDistance, OfBallsIsTheirDistanceLessTheirReach) {
  const SignedDistance distance = DistanceOf(Ball(2), PoseAt(0, 1.5, 0), Ball(4), {});
  ExpectNear(distance, -1.5);
  EXPECT_NEAR((distance.normal - Vector3d::UnitY()).norm(), 0, 1e-15);
  ExpectNear(DistanceOf(Ball(2), PoseAt(0, 0, 7), Ball(4), {}), 4);
  ExpectNear(DistanceOf(Ball(2), {}, Ball(4), {}), -3);
}

TEST(SignedDistance, OfEdgesAcrossIsAlongTheirProduct) {
  // Each box stands on an edge, one along x and the other along z.
  const double turn = std::numbers::pi / 4, height = 2 * std::sqrt(2.0);
  Pose a = PoseAt(0, height - 0.25, 0), b;
  a.orientation = Eigen::AngleAxisd(turn, Vector3d::UnitX());
  b.orientation = Eigen::AngleAxisd(turn, Vector3d::UnitZ());
  const SignedDistance distance = DistanceOf(Box(2, 2, 2), a, Box(2, 2, 2), b);
  ExpectNear(distance, -0.25);
  EXPECT_NEAR((distance.normal - Vector3d::UnitY()).norm(), 0, 1e-12);
}

TEST(SignedDistance, FromAHalfSpaceIsThatOfTheDeepestPoint) {
  distributions::Stream stream(4);
  for (int i = 0; i < 300; ++i) {
    const Solid solid = i % 8 == 7 ? Torus() : RandomSolid(stream, kOracleShapes[i % 8], 4);
    const Pose pose{RandomDirection(stream), stream.Turn()};
    const Vector3d normal = RandomDirection(stream);
    const double offset = stream.Uniform(-2, 2);
    const SignedDistance plane = DistanceOf(solid, pose, exact::HalfSpace{normal, offset});
    EXPECT_EQ(plane.normal, normal);
    // A box as wide as the world gives the same result.
    const Eigen::AngleAxisd from_y(std::acos(normal.y()),
                                   Vector3d::UnitY().cross(normal).normalized());
    const Pose below{normal * (offset - 50), Eigen::Quaterniond(from_y)};
    const SignedDistance box = DistanceOf(solid, pose, Box(100, 100, 100), below);
    if (i % 8 == 7) {
      EXPECT_LE(plane.lower, box.upper);
      continue;
    }
    ExpectNear(box, (plane.lower + plane.upper) / 2, 10);
  }
}

TEST(SignedDistance, FromASurfaceIsThatFromItsNearestTriangle) {
  distributions::Stream stream(5);
  meshes::Mesh mesh;
  constexpr std::uint32_t kCells = 12;
  for (std::uint32_t z = 0; z <= kCells; ++z)
    for (std::uint32_t x = 0; x <= kCells; ++x)
      mesh.vertices.emplace_back(x, std::sin(0.7 * x) * std::cos(0.5 * z), z);
  for (std::uint32_t z = 0; z < kCells; ++z)
    for (std::uint32_t x = 0; x < kCells; ++x) {
      const std::uint32_t a = z * (kCells + 1) + x, b = a + kCells + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  const auto form =
      std::make_shared<const objects::ConvexDecomposition>(objects::MakeSurface("waves", mesh));
  Solid surface{Shape::kCompound, 12 * form->proportions};
  surface.compound = std::make_shared<const objects::Compound>(form, surface.sides);
  const Pose ground{RandomDirection(stream), stream.Turn()};
  for (int i = 0; i < Cases(100); ++i) {
    const Solid ball = Ball(stream.LogUniform(0.1, 3));
    const Vector3d local(stream.Uniform(-7, 7), stream.Uniform(-2, 3), stream.Uniform(-7, 7));
    const Pose pose{ground.position + ground.orientation * local};
    // The distance of a point from a triangle: from its edges, or from its plane.
    double least = INFINITY;
    for (std::size_t piece = 0; piece < surface.PieceCount(); ++piece) {
      const auto corner = [&](std::size_t k) { return surface.compound->Corner(piece, k % 3); };
      const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      const Vector3d foot = local - normal.dot(local - corner(0)) * normal;
      bool is_over = true;
      for (std::size_t k = 0; k < 3; ++k) {
        least = std::min(least, (NearestOnSegment(corner(k), corner(k + 1), local) - local).norm());
        is_over = is_over && (corner(k + 1) - corner(k)).cross(foot - corner(k)).dot(normal) > 0;
      }
      if (is_over) least = std::min(least, (foot - local).norm());
    }
    const double exact = least - ball.sides.x() / 2;
    ExpectNear(DistanceOf(ball, pose, surface, ground), exact, 10);
    ExpectNear(DistanceOf(surface, ground, ball, pose, exact + 0.1), exact, 10);
    if (exact > 0) {
      EXPECT_GE(DistanceOf(ball, pose, surface, ground, exact / 2).lower, exact / 2);
    }
  }
  EXPECT_GE(DistanceOf(surface, ground, surface, {}, 1).lower, 1) << "neither has an inside";
}

bool IsOneNormal(const Solid& a, const Pose& pose_a, const Solid& b, double fraction = 0.01) {
  return exact::HasOneNormal(a, pose_a, b, {}, DistanceOf(a, pose_a, b, {}), fraction);
}

TEST(HasOneNormal, IfAnotherWayOutIsLonger) {
  const Solid cube = Box(1, 1, 1), cylinder{Shape::kCylinder, {1, 3, 1}},
              egg{Shape::kEllipsoid, {1, 2, 3}};
  EXPECT_TRUE(IsOneNormal(cube, PoseAt(0.1, 0.95, 0.2), cube)) << "two faces have the same normal";
  EXPECT_TRUE(IsOneNormal(cube, PoseAt(0.1, 0.5, 0.2), cube));
  EXPECT_FALSE(IsOneNormal(cube, {}, cube));
  EXPECT_FALSE(IsOneNormal(cube, PoseAt(0, 0.5, 0.5), cube));
  EXPECT_FALSE(IsOneNormal(cube, PoseAt(0, 0.5, 0.501), cube));
  EXPECT_TRUE(IsOneNormal(cube, PoseAt(0, 0.5, 0.51), cube));
  EXPECT_TRUE(IsOneNormal(cube, PoseAt(0, 0.5, 0.501), cube, 1e-4));
  EXPECT_TRUE(IsOneNormal(Ball(0.2), PoseAt(0.3, 0, 0), cylinder));
  EXPECT_FALSE(IsOneNormal(Ball(0.2), PoseAt(0.001, 0, 0), cylinder)) << "near the axis";
  EXPECT_TRUE(IsOneNormal(Ball(1), PoseAt(0, 0.9, 0), Ball(1)));
  EXPECT_TRUE(IsOneNormal(Ball(1), PoseAt(0.1, 0, 0), egg));
  EXPECT_FALSE(IsOneNormal(Ball(1), {}, egg)) << "either way along x";
  EXPECT_TRUE(IsOneNormal(Ball(1), PoseAt(0, 0, 1.9), egg));
}

TEST(HasOneNormal, IfNoOtherPartsOverlapAsDeeply) {
  // Between two pieces of the ring, whose tube is a polygon.
  const Solid torus = Torus();
  const Solid post{Shape::kCuboid, {0.3, 3, 0.3}};
  EXPECT_TRUE(IsOneNormal(Ball(0.5), PoseAt(1.5, 0.7, 0.2), torus));
  EXPECT_TRUE(IsOneNormal(post, PoseAt(1.0, 0, 0.4), torus));
}

}  // namespace
}  // namespace cdb::tests
