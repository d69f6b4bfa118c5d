#include "library/objects/solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "compiler/schema/catalogue_table.h"
#include "library/distributions/stream.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

const Vector3d kSides(3, 5, 2);

bool Inside(const objects::Solid& solid, const Vector3d& p) {
  return objects::Visit(solid, [&](auto form) { return form.Contains(solid.sides, p); });
}

struct Form {
  objects::Shape shape;
  Eigen::Vector2d exponents = Eigen::Vector2d::Ones();
};

class EverySolid : public testing::TestWithParam<Form> {
 protected:
  objects::Solid solid(const Vector3d& sides = kSides) const {
    return {GetParam().shape, sides, nullptr, GetParam().exponents};
  }
};

std::vector<Form> AllForms() {
  std::vector<Form> forms;
  for (const objects::Shape shape : objects::kClosedShapes) forms.push_back({shape});
  for (const auto& [e1, e2] : {std::pair(0.3, 0.5), std::pair(1.5, 0.4), std::pair(0.2, 2.0),
                               std::pair(2.0, 2.0), std::pair(1.0, 1.7)})
    forms.push_back({objects::Shape::kSuperellipsoid, {e1, e2}});
  return forms;
}

INSTANTIATE_TEST_SUITE_P(Shapes, EverySolid, testing::ValuesIn(AllForms()));

TEST_P(EverySolid, VolumeCentreAndInertiaAreThoseOfItsPoints) {
  const objects::Solid s = solid();
  distributions::Stream stream(1);
  // Points in the box around the solid; a cone extends from y = -h/4 to 3h/4.
  constexpr int kPoints = 1000000;
  double inside = 0;
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero(), fourths = Vector3d::Zero();
  for (int i = 0; i < kPoints; ++i) {
    Vector3d p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = stream.Uniform(-0.5, 0.5) * s.sides[axis];
    p.y() += s.BoxCentre();
    if (!Inside(s, p)) continue;
    ++inside;
    sum += p;
    squares += p.cwiseAbs2();
    fourths += p.cwiseAbs2().cwiseAbs2();
  }
  // Every bound is five standard deviations of the mean in question.
  const double share = inside / kPoints;
  const double box = s.sides.prod();
  EXPECT_NEAR(s.Volume(), share * box, 5 * box * std::sqrt(share * (1 - share) / kPoints) + 1e-12);
  const Vector3d mean_square = squares / inside;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum[axis] / inside, 0, 5 * std::sqrt(mean_square[axis] / inside));
    const int other = (axis + 1) % 3, third = (axis + 2) % 3;
    const double variance = (fourths[other] + fourths[third]) / inside * 2;  // at most
    EXPECT_NEAR(s.InertiaPerMass()[axis], mean_square[other] + mean_square[third],
                5 * std::sqrt(variance / inside));
  }
}

TEST_P(EverySolid, SupportIsTheFarthestPointAndOnTheSurface) {
  const objects::Solid s = solid();
  distributions::Stream stream(2);
  for (int i = 0; i < 300; ++i) {
    const Vector3d direction(stream.Normal(), stream.Normal(), stream.Normal());
    const Vector3d support = s.Support(direction);
    EXPECT_TRUE(Inside(s, support * (1 - 1e-12)));
    EXPECT_FALSE(Inside(s, support * (1 + 1e-9)));
    for (int j = 0; j < 300; ++j) {
      Vector3d p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = stream.Uniform(-0.5, 0.5) * s.sides[axis];
      p.y() += s.BoxCentre();
      if (Inside(s, p)) {
        EXPECT_LE(direction.dot(p), direction.dot(support) + 1e-12);
      }
    }
  }
  EXPECT_TRUE(s.Support(Vector3d::Zero()).allFinite());
}

TEST_P(EverySolid, BoundsAreTheSidesUnturnedAndHoldTheSolidTurned) {
  const objects::Solid s = solid();
  const objects::Box box = objects::Bounds(s, Eigen::Quaterniond::Identity());
  EXPECT_TRUE((box.upper - box.lower).isApprox(kSides, 1e-15));
  distributions::Stream stream(3);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond turn = stream.Turn();
    const objects::Box turned = objects::Bounds(s, turn);
    Vector3d reached = Vector3d::Constant(-1e9);
    for (int j = 0; j < 2000; ++j) {
      const Vector3d direction(stream.Normal(), stream.Normal(), stream.Normal());
      const Vector3d p = turn * s.Support(direction);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(p[axis], turned.upper[axis] + 1e-12);
        EXPECT_GE(p[axis], turned.lower[axis] - 1e-12);
        reached[axis] = std::max(reached[axis], p[axis]);
      }
    }
    // The bound is tight: one of 2000 directions lies within 0.2 rad of each axis, except in one
    // case in 10^8, and its support point is then short by at most the diameter times sin 0.2.
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_GT(reached[axis], turned.upper[axis] - std::sin(0.2) * kSides.norm());
  }
}

TEST_P(EverySolid, InnerBallTouchesTheSurfaceFromInside) {
  const objects::Solid s = solid({4, 5, 4});
  distributions::Stream stream(4);
  const auto random = [&] { return Vector3d(stream.Normal(), stream.Normal(), stream.Normal()); };
  double nearest = 1e9;
  Vector3d best = Vector3d::UnitY();
  for (int i = 0; i < 20000; ++i) {
    // A flat face is visible only from one direction: the second half searches near the best.
    const double step = i < 10000 ? 0 : 0.1 * std::exp(-(i - 10000) / 1000.0);
    const Vector3d d = (step > 0 ? Vector3d(best + step * random()) : random()).normalized();
    EXPECT_TRUE(Inside(s, d * s.InnerRadius() * (1 - 1e-12)));
    if (d.dot(s.Support(d)) >= nearest) continue;
    nearest = d.dot(s.Support(d));
    best = d;
  }
  EXPECT_GE(nearest, s.InnerRadius() * (1 - 1e-12));
  EXPECT_LT(nearest, s.InnerRadius() * 1.01);
}

TEST_P(EverySolid, OuterBallHoldsItClosely) {
  const objects::Solid s = solid();
  distributions::Stream stream(4);
  double farthest = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d d = Vector3d(stream.Normal(), stream.Normal(), stream.Normal()).normalized();
    farthest = std::max(farthest, s.Support(d).norm());
  }
  EXPECT_LE(farthest, s.OuterRadius() * (1 + 1e-12));
  EXPECT_GT(farthest, s.OuterRadius() * 0.99);
}

TEST(Solid, FillsAboutTheFractionOfItsBoxThatTheTableSays) {
  for (const objects::Shape shape : objects::kClosedShapes) {
    const auto type = std::ranges::find(schema::kObjectTypeTable, objects::TypeOf(shape),
                                        &schema::ObjectType::name);
    EXPECT_NEAR((objects::Solid{shape, Vector3d::Ones()}).Volume(), type->fill, 0.005);
  }
}

TEST(Solid, KnownVolumes) {
  EXPECT_DOUBLE_EQ((objects::Solid{objects::Shape::kEllipsoid, {2, 2, 2}}.Volume()),
                   4 * std::numbers::pi / 3);
  EXPECT_DOUBLE_EQ((objects::Solid{objects::Shape::kCylinder, {2, 3, 2}}.Volume()),
                   3 * std::numbers::pi);
  EXPECT_DOUBLE_EQ((objects::Solid{objects::Shape::kCone, {2, 3, 2}}.Volume()), std::numbers::pi);
  EXPECT_DOUBLE_EQ((objects::Solid{objects::Shape::kCapsule, {2, 6, 2}}.Volume()),
                   std::numbers::pi * 16 / 3);
  EXPECT_DOUBLE_EQ((objects::Solid{objects::Shape::kTetrahedron, {1, 2, 3}}.Volume()), 2);
  // 2/5 r^2 for a ball.
  EXPECT_DOUBLE_EQ((objects::Solid{objects::Shape::kEllipsoid, {2, 2, 2}}.InertiaPerMass().x()),
                   0.4);
}

objects::Solid Superellipsoid(double e1, double e2) {
  return {objects::Shape::kSuperellipsoid, kSides, nullptr, {e1, e2}};
}

void ExpectLike(const objects::Solid& one, const objects::Solid& other, double tolerance) {
  EXPECT_NEAR(one.Volume() / other.Volume(), 1, tolerance);
  EXPECT_NEAR(one.InnerRadius() / other.InnerRadius(), 1, tolerance);
  EXPECT_NEAR(one.OuterRadius() / other.OuterRadius(), 1, tolerance);
  EXPECT_TRUE(one.InertiaPerMass().isApprox(other.InertiaPerMass(), tolerance));
  distributions::Stream stream(6);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d d(stream.Normal(), stream.Normal(), stream.Normal());
    const double height = d.dot(other.Support(d));
    EXPECT_NEAR(d.dot(one.Support(d)), height, tolerance * height);
  }
}

TEST(Superellipsoid, HasTheOtherShapesAsItsLimits) {
  ExpectLike(Superellipsoid(1, 1), {objects::Shape::kEllipsoid, kSides}, 1e-14);
  ExpectLike(Superellipsoid(1e-9, 1e-9), {objects::Shape::kCuboid, kSides}, 1e-8);
  ExpectLike(Superellipsoid(1e-9, 1), {objects::Shape::kCylinder, kSides}, 1e-8);
  // The smallest exponent that there is gives no NaN.
  ExpectLike(Superellipsoid(5e-324, 5e-324), {objects::Shape::kCuboid, kSides}, 1e-14);
}

TEST(Superellipsoid, WithExponentsOf2IsAnOctahedron) {
  const objects::Solid solid = Superellipsoid(2, 2);
  const Vector3d half = kSides / 2;
  EXPECT_NEAR(solid.Volume(), kSides.prod() / 6, 1e-13);
  const Vector3d squares = half.cwiseAbs2() / 10;
  EXPECT_NEAR(solid.InertiaPerMass().x(), squares.y() + squares.z(), 1e-14);
  EXPECT_NEAR(solid.InertiaPerMass().y(), squares.x() + squares.z(), 1e-14);
  EXPECT_NEAR(solid.InnerRadius(), 1 / half.cwiseInverse().norm(), 1e-14);
  distributions::Stream stream(7);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d d(stream.Normal(), stream.Normal(), stream.Normal());
    EXPECT_EQ(d.dot(solid.Support(d)), d.cwiseProduct(half).cwiseAbs().maxCoeff());
  }
}

}  // namespace
}  // namespace cdb::tests
