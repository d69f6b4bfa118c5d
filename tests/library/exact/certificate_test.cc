// Every answer of the referee is checked by its proof, with the equations of oracle.h alone.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>

#include "library/exact/least_height.h"
#include "library/exact/signed_distance.h"
#include "library/objects/surface.h"
#include "tests/library/exact/oracle.h"
#include "tests/library/objects/random_solids.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using exact::SignedDistance;
using objects::Pose;
using objects::Shape;
using objects::Solid;

/// The six closed forms, then a ball, a round capsule and cylinder, a compound, a triangle, a
/// superellipsoid.
constexpr std::size_t kKinds = 12;

Solid Triangle(distributions::Stream& stream, double most) {
  meshes::Mesh mesh;
  for (int i = 0; i < 3; ++i)
    mesh.vertices.push_back(RandomDirection(stream) * stream.LogUniform(1, most));
  mesh.triangles = {{0, 1, 2}};
  const auto form =
      std::make_shared<const objects::ConvexDecomposition>(objects::MakeSurface("t", mesh));
  Solid solid{Shape::kCompound, most * form->proportions};
  solid.compound = std::make_shared<const objects::Compound>(form, solid.sides);
  return solid;
}

Solid Draw(distributions::Stream& stream, std::size_t kind, double most) {
  if (kind < 6) return RandomSolid(stream, kOracleShapes[kind], most);
  if (kind == 9) return Torus();
  if (kind == 10) return Triangle(stream, most);
  if (kind == 11) return RandomSolid(stream, Shape::kSuperellipsoid, most);
  Solid solid{kind == 6 ? Shape::kEllipsoid : kind == 7 ? Shape::kCapsule : Shape::kCylinder};
  solid.sides.setConstant(stream.LogUniform(1, std::sqrt(most)));
  if (kind > 6) solid.sides.y() *= stream.LogUniform(1, std::sqrt(most));
  return solid;
}

struct Case {
  Solid a, b;
  Pose pose_a, pose_b;
  double Scale() const {
    return a.OuterRadius() + b.OuterRadius() + (pose_a.position - pose_b.position).norm();
  }
  SignedDistance Distance() const { return exact::DistanceOf(a, pose_a, b, pose_b); }
};

/// The gap of the two pieces that are claimed to be the closest.
double GapAlong(const Case& c, const SignedDistance& pieces, const Vector3d& normal) {
  return GapAlong(OracleBody{c.a, c.pose_a, pieces.piece_a},
                  OracleBody{c.b, c.pose_b, pieces.piece_b}, normal);
}

bool HasPieces(const Case& c) { return c.a.PieceCount() * c.b.PieceCount() > 1; }

/// Checks all that `claim` says of its two pieces.
void Check(distributions::Stream& stream, const Case& c, const SignedDistance& claim) {
  const double rounding = 1e-14 * c.Scale();
  ASSERT_LE(claim.lower, claim.upper);
  ASSERT_NEAR(claim.normal.norm(), 1, 1e-14);
  // The separating plane. Of several pairs of pieces, that of another may be a little closer.
  const double gap = GapAlong(c, claim, claim.normal);
  ASSERT_GE(gap, claim.lower - rounding);
  ASSERT_LE(gap, claim.lower + (HasPieces(c) ? 1e-10 * c.Scale() : rounding));
  // The witnesses. A thin solid that contains a point up to rounding is farther from it by its
  // own equation.
  const double outside = 1e-12 * c.Scale();
  ASSERT_LE(OutsideOf(c.a, claim.piece_a, c.pose_a, claim.on_a), outside);
  ASSERT_LE(OutsideOf(c.b, claim.piece_b, c.pose_b, claim.on_b), outside);
  ASSERT_LE((claim.on_a - claim.on_b).norm(), std::max(0.0, claim.upper) + outside);
  // No direction is better: in all directions, and close to the normal.
  for (int k = 0; k < 60; ++k) {
    const double spread = k % 2 == 0 ? 10 : std::pow(10, -k / 6);
    const Vector3d other = (claim.normal + spread * RandomDirection(stream)).normalized();
    ASSERT_LE(GapAlong(c, claim, other), claim.upper + rounding);
  }
}

/// Bodies of these kinds, apart by `gap` times the smaller one along a random line; a negative one
/// makes them overlap, and one below -1 places one centre in the other body.
Case DrawCase(distributions::Stream& stream, std::size_t kind_a, std::size_t kind_b, double most,
              double gap) {
  Case c{Draw(stream, kind_a, most), Draw(stream, kind_b, most), {}, {}};
  c.pose_a = {RandomDirection(stream), stream.Turn()};
  c.pose_b.orientation = stream.Turn();
  const Vector3d way = RandomDirection(stream);
  double near = 0, far = c.a.OuterRadius() + c.b.OuterRadius();
  const double smaller = std::min(c.a.OuterRadius(), c.b.OuterRadius());
  const auto place = [&](double at) { c.pose_b.position = c.pose_a.position + at * way; };
  for (int i = 0; i < 50 && gap > -1; ++i) {
    place((near + far) / 2);
    const bool is_apart = exact::DistanceOf(c.a, c.pose_a, c.b, c.pose_b, 0).upper > 0;
    (is_apart ? far : near) = (near + far) / 2;
  }
  place(gap > -1 ? far + gap * smaller : stream.Uniform(0, 0.3) * smaller);
  return c;
}

/// Tori of many pieces, and superellipsoids, whose support is computed by powers.
bool IsCostly(std::size_t kind) { return kind == 9 || kind == 11; }

class Certificate : public testing::TestWithParam<std::size_t> {};

TEST_P(Certificate, HoldsForEveryPairAtEveryDepth) {
  distributions::Stream stream(GetParam());
  for (std::size_t other = 0; other < kKinds; ++other) {
    if (other == 10 && GetParam() == 10) continue;
    for (const double gap : {-2.0, -0.1, -1e-3, -1e-7, 0.0, 1e-9, 1e-4, 0.5}) {
      const bool is_costly = IsCostly(other) || IsCostly(GetParam());
      for (int i = 0; i < Cases(is_costly ? 2 : 12); ++i) {
        const Case c = DrawCase(stream, GetParam(), other, 4, gap);
        const SignedDistance claim = c.Distance();
        EXPECT_TRUE(claim.IsTight(std::min(c.a.OuterRadius(), c.b.OuterRadius())))
            << other << ' ' << gap << ": " << claim.lower << " .. " << claim.upper;
        Check(stream, c, claim);
        if (HasFatalFailure()) FAIL() << GetParam() << " and " << other << ", gap " << gap;
      }
    }
  }
}

TEST_P(Certificate, IsOfTheDistanceThatASearchOfAllDirectionsFinds) {
  // With one case for each gap, the stream of the round capsule draws a tetrahedron with two
  // support points that are equal but for a rounding.
  for (const int cases : std::set<int>{1, Cases(2)}) {
    std::size_t drawn = 0;
    distributions::Stream stream(GetParam() + 500);
    for (std::size_t other = 0; other < kKinds; ++other) {
      if (other == 10 && GetParam() == 10) continue;
      for (const double gap : {-2.0, -0.1, -1e-3, 1e-3, 0.5}) {
        for (int i = 0; i < (IsCostly(other) || IsCostly(GetParam()) ? 1 : cases); ++i) {
          SCOPED_TRACE(testing::Message() << GetParam() << " and " << other << ", gap " << gap);
          const Case c = DrawCase(stream, GetParam(), other, 4, gap);
          const SignedDistance claim = c.Distance();
          // The search is code of this test, and slow.
          if (kAddressSanitizer && (drawn++ + other) % 10 != 0) continue;
          const OracleGap searched = SearchedGap(c.a, c.pose_a, c.b, c.pose_b);
          const double size = std::min(c.a.OuterRadius(), c.b.OuterRadius());
          EXPECT_LE(searched.gap, claim.upper + 1e-13 * c.Scale());
          EXPECT_GE(searched.gap, claim.lower - 1e-6 * size);
          EXPECT_NEAR(-claim.Depth(), searched.gap, 1e-6 * size);
          EXPECT_NEAR(GapAlong(c, claim, claim.normal), searched.gap, 1e-6 * size);
        }
      }
    }
  }
}

/// The least height of the differences of the first pieces.
exact::LeastHeight LeastHeightOf(const Case& c, bool by_polytope, double tolerance,
                                 const Vector3d& guess) {
  const Eigen::Matrix3d turn_a = c.pose_a.orientation.toRotationMatrix(),
                        turn_b = c.pose_b.orientation.toRotationMatrix();
  const exact::ConvexPart a(c.a, 0, turn_a, Vector3d::Zero()),
      b(c.b, 0, turn_b, c.pose_b.position - c.pose_a.position);
  exact::HeightGoal goal;
  goal.scale = c.Scale();
  goal.tolerance = tolerance;
  goal.guess = guess;
  goal.by_polytope = by_polytope;
  return exact::FindLeastHeight(
      [&](const Vector3d& direction) -> exact::Difference {
        return {a.CoreSupport(direction), b.CoreSupport(-direction)};
      },
      goal);
}

TEST_P(Certificate, OfAPolytopeIsThatOfBranchAndBoundInAnyOrder) {
  distributions::Stream stream(GetParam() + 600);
  for (std::size_t other = 0; other < kKinds; ++other) {
    if (other == 10 && GetParam() == 10) continue;
    for (int i = 0; i < Cases(8); ++i) {
      const Case c = DrawCase(stream, GetParam(), other, 4, i % 2 == 0 ? -2 : -0.1);
      const double side = 2 * std::min(c.a.LeastHalfExtent(), c.b.LeastHalfExtent());
      if (!(side > 0)) continue;  // a triangle has none
      const Vector3d guess = RandomDirection(stream);
      const exact::LeastHeight exact = LeastHeightOf(c, false, 1e-3 * side, guess);
      const Case swapped{c.b, c.a, c.pose_b, c.pose_a};
      for (const double tolerance : {1e-3, 0.05})
        for (const Case& order : {c, swapped}) {
          const exact::LeastHeight found =
              LeastHeightOf(order, true, tolerance * side, RandomDirection(stream));
          EXPECT_LE(found.upper - found.lower, 1.01 * tolerance * side) << other;
          EXPECT_LE(found.lower, exact.upper + 1e-12) << other;
          EXPECT_GE(found.upper, exact.lower - 1e-12) << other;
        }
    }
  }
}

TEST_P(Certificate, HoldsForNeedlesAndPlates) {
  distributions::Stream stream(GetParam() + 100);
  for (std::size_t other = 0; other < kKinds; ++other) {
    if (other == 9 || GetParam() == 9 || (other == 10 && GetParam() == 10)) continue;
    // Some distances of such superellipsoids are known to 1e-7 of the size only.
    const bool is_super = other == 11 || GetParam() == 11;
    for (const double gap : {-2.0, -1e-2, -1e-5, 0.0, 1e-6, 0.2}) {
      for (int i = 0; i < Cases(is_super ? 1 : 4); ++i) {
        const Case c = DrawCase(stream, GetParam(), other, 1000, gap);
        const SignedDistance claim = c.Distance();
        EXPECT_TRUE(is_super || claim.IsTight(std::min(c.a.OuterRadius(), c.b.OuterRadius())))
            << other << ' ' << gap << ": " << claim.lower << " .. " << claim.upper;
        Check(stream, c, claim);
        if (HasFatalFailure()) FAIL() << GetParam() << " and " << other << ", gap " << gap;
      }
    }
  }
}

TEST_P(Certificate, IsTheSameInAnyOrderAndFrame) {
  distributions::Stream stream(GetParam() + 200);
  for (std::size_t other = 0; other < kKinds; ++other) {
    if (other == 10 && GetParam() == 10) continue;
    for (const double gap : {-2.0, -1e-3, 1e-3}) {
      const Case c = DrawCase(stream, GetParam(), other, 4, gap);
      const SignedDistance claim = c.Distance();
      const double wide = 1e-10 * c.Scale();
      const SignedDistance swapped = exact::DistanceOf(c.b, c.pose_b, c.a, c.pose_a);
      EXPECT_NEAR(swapped.lower, claim.lower, wide);
      EXPECT_NEAR(swapped.upper, claim.upper, wide);
      Case moved = c;
      const Eigen::Quaterniond turn = stream.Turn();
      for (Pose* pose : {&moved.pose_a, &moved.pose_b})
        *pose = {turn * pose->position + Vector3d(3, 1, -2), turn * pose->orientation};
      const SignedDistance there = moved.Distance();
      EXPECT_NEAR(there.lower, claim.lower, wide);
      EXPECT_NEAR(there.upper, claim.upper, wide);
      if (exact::HasOneNormal(c.a, c.pose_a, c.b, c.pose_b, claim, 0.01)) {
        EXPECT_NEAR((turn * claim.normal - there.normal).norm(), 0, 1e-4) << other << ' ' << gap;
        EXPECT_NEAR((swapped.normal + claim.normal).norm(), 0, 1e-4) << other << ' ' << gap;
      }
    }
  }
}

TEST_P(Certificate, HoldsAtEverySize) {
  distributions::Stream stream(GetParam() + 300);
  for (std::size_t other = 0; other < kKinds; ++other) {
    if (other == 10 && GetParam() == 10) continue;
    for (const double gap : {-2.0, -1e-4, 1e-4}) {
      const Case c = DrawCase(stream, GetParam(), other, 4, gap);
      const SignedDistance claim = c.Distance();
      for (const double size : {1e-7, 1e7}) {
        Case scaled = c;
        for (Solid* solid : {&scaled.a, &scaled.b}) {
          solid->sides *= size;
          if (solid->compound != nullptr)
            solid->compound = std::make_shared<const objects::Compound>(
                solid->compound->shared_form(), solid->sides);
        }
        for (Pose* pose : {&scaled.pose_a, &scaled.pose_b}) pose->position *= size;
        const SignedDistance there = scaled.Distance();
        EXPECT_NEAR(there.lower / size, claim.lower, 1e-10 * c.Scale());
        EXPECT_NEAR(there.upper / size, claim.upper, 1e-10 * c.Scale());
        Check(stream, scaled, there);
      }
    }
  }
}

TEST_P(Certificate, TellsThatBodiesAreOutOfReach) {
  distributions::Stream stream(GetParam() + 400);
  for (std::size_t other = 0; other < kKinds; ++other) {
    if (other == 10 && GetParam() == 10) continue;
    const Case c = DrawCase(stream, GetParam(), other, 4, 0.5);
    const SignedDistance claim = c.Distance();
    for (const double part : {0.0, 0.5, 0.99})
      EXPECT_GE(exact::DistanceOf(c.a, c.pose_a, c.b, c.pose_b, part * claim.lower).lower,
                part * claim.lower);
    const SignedDistance within =
        exact::DistanceOf(c.a, c.pose_a, c.b, c.pose_b, 1.01 * claim.upper);
    EXPECT_NEAR(within.upper, claim.upper, 1e-9 * c.Scale());
  }
}

std::string KindName(const testing::TestParamInfo<std::size_t>& info) {
  static constexpr const char* kNames[kKinds] = {
      "ellipsoid", "cuboid",        "cylinder",       "cone",  "capsule",  "tetrahedron",
      "ball",      "round_capsule", "round_cylinder", "torus", "triangle", "superellipsoid"};
  return kNames[info.param];
}

INSTANTIATE_TEST_SUITE_P(Every, Certificate, testing::Range(std::size_t{0}, kKinds), KindName);

}  // namespace
}  // namespace cdb::tests
