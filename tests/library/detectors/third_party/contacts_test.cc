// Narrow phases of other libraries compared with exact contacts, each within its measured error.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>

#include "library/distributions/stream.h"
#include "library/exact/signed_distance.h"
#include "tests/library/detectors/third_party/third_party.h"
#include "tests/library/detectors/third_party/two_bodies.h"
#include "tests/library/objects/random_solids.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// The permitted errors, in units of the bodies' size.
struct Claim {
  double under = 1e-9, over = 1e-9;  ///< depth too small, too large
  double normal = 1e-6;              ///< distance of the normal's end from its exact position
  double blind = 0;                  ///< shallower overlaps may be missed
  double missed = 0;                 ///< fraction of the other overlaps that may be missed
  double tie = 0;  ///< any normal along which the bodies overlap by only so much more is right
};

/// MPR searches along the line of the centres and takes the first way out.
constexpr Claim kPortal = {.under = 1e-4, .over = 0.3, .normal = 1.4};

Claim ClaimOf(std::string_view detector, bool has_ball, bool is_hull) {
  if (detector == "ccd_gjk")
    return {.under = 1e-3, .over = 1e-3, .normal = 0.05, .missed = has_ball ? 0.04 : 0.001};
  if (detector == "ccd_mpr") return kPortal;
  if (detector == "fcl_gjk" && is_hull) return kPortal;
  // Of two boxes, it prefers the normal of a face to that of two edges if the depth is within 5 %.
  if (detector == "fcl_gjk")
    return {.over = has_ball ? 1e-9 : 0.05, .normal = 0.05, .tie = has_ball ? 0 : 0.01};
  // Trees of triangles: the mesh of a ball lies inside it.
  if (has_ball) return {.under = 0.03, .over = 0.03, .normal = 0.3, .blind = 0.03};
  return {};
}

objects::Solid Draw(distributions::Stream& stream, bool is_ball, double size) {
  if (is_ball) return {objects::Shape::kEllipsoid, Vector3d::Constant(stream.Uniform(1, 3) * size)};
  return {objects::Shape::kCuboid,
          Vector3d(stream.Uniform(1, 3), stream.Uniform(1, 3), stream.Uniform(1, 3)) * size};
}

struct Case {
  objects::Solid a, b;
  objects::Pose pose_a, pose_b;
};

/// Bodies of 1 to 3 sizes that overlap by this depth along the line of their centres, or are apart
/// if it is negative.
Case DrawCase(distributions::Stream& stream, bool is_ball_a, bool is_ball_b, double size,
              double overlap) {
  Case drawn{Draw(stream, is_ball_a, size), Draw(stream, is_ball_b, size), {}, {}};
  const Vector3d way = RandomDirection(stream);
  drawn.pose_a = {RandomDirection(stream) * stream.Uniform(0, 5) * size, stream.Turn()};
  drawn.pose_b.orientation = stream.Turn();
  double touching = 0, apart = 10 * size;
  for (int i = 0; i < 60; ++i) {
    const double middle = (touching + apart) / 2;
    drawn.pose_b.position = drawn.pose_a.position + middle * way;
    const double gap = exact::DistanceOf(drawn.a, drawn.pose_a, drawn.b, drawn.pose_b, 0).upper;
    (gap > 0 ? apart : touching) = middle;
  }
  drawn.pose_b.position = drawn.pose_a.position + (touching - overlap * size) * way;
  return drawn;
}

class ThirdPartyContacts : public testing::TestWithParam<schema::DetectorInfo> {
 protected:
  void SetUp() override {
    if (!Make())
      GTEST_SKIP() << "the part '" << GetParam().part << "' is not built (./setup --third-party)";
  }
  std::unique_ptr<Detector> Make() { return MakeThirdParty(GetParam()); }
  std::string_view name() const { return GetParam().name; }

  /// Creates a detector for each case, because it reads the bodies only once.
  std::vector<Contact> ContactsOf(const Case& of, CuboidAs cuboids) {
    const TwoBodies bodies(of.a, of.pose_a, of.b, of.pose_b, cuboids);
    std::vector<Contact> contacts = tests::ContactsOf(*Make(), bodies);
    for (const Contact& contact : contacts) {
      EXPECT_EQ(contact.a, 0u);
      EXPECT_EQ(contact.b, 1u);
      const auto eigen = [](const Vec3& v) { return Vector3d(v.x, v.y, v.z); };
      const Vector3d normal = eigen(contact.normal);
      EXPECT_NEAR(normal.norm(), 1, 1e-6);
      EXPECT_NEAR((eigen(contact.on_a) - eigen(contact.on_b)).dot(normal), contact.distance,
                  1e-6 * of.a.sides.norm());
    }
    return contacts;
  }
};

const Contact* Deepest(const std::vector<Contact>& contacts) {
  const auto deepest = std::ranges::min_element(contacts, {}, &Contact::distance);
  return deepest == contacts.end() ? nullptr : &*deepest;
}

TEST_P(ThirdPartyContacts, TellDepthAndNormalOfBallsBoxesAndHulls) {
  distributions::Stream stream(1);
  for (const double size : {0.05, 1.0, 50.0}) {
    for (int kind = 0; kind < 5; ++kind) {
      const bool is_ball_a = kind < 2, is_ball_b = kind == 0 || kind == 2, is_hull = kind == 4;
      const Claim claim = ClaimOf(name(), is_ball_a || is_ball_b, is_hull);
      constexpr int kCases = 50;
      int missed = 0;
      for (int i = 0; i < kCases; ++i) {
        const Case drawn = DrawCase(stream, is_ball_a, is_ball_b, size, stream.Uniform(0.005, 0.2));
        const exact::SignedDistance exact =
            exact::DistanceOf(drawn.a, drawn.pose_a, drawn.b, drawn.pose_b);
        const double depth = exact.Depth();
        ASSERT_GT(depth, 0);
        const auto contacts = ContactsOf(drawn, is_hull ? CuboidAs::kHull : CuboidAs::kBox);
        const Contact* contact = Deepest(contacts);
        if (contact == nullptr || contact->distance >= 0) {
          missed += depth > claim.blind * size;
          continue;
        }
        EXPECT_GE(-contact->distance, depth - claim.under * size) << size << ' ' << kind;
        EXPECT_LE(-contact->distance, depth + claim.over * size) << size << ' ' << kind;
        if (!exact::HasOneNormal(drawn.a, drawn.pose_a, drawn.b, drawn.pose_b, exact,
                                 0.01 * size / depth))
          continue;  // another is as good
        const Vector3d normal(contact->normal.x, contact->normal.y, contact->normal.z);
        const double along = normal.dot(WorldSupport(drawn.b, drawn.pose_b, normal) -
                                        WorldSupport(drawn.a, drawn.pose_a, -normal));
        if (claim.tie == 0 || along > depth + claim.tie * size) {
          EXPECT_LE((normal - exact.normal).norm(), claim.normal) << size << ' ' << kind;
        }
      }
      EXPECT_LE(missed, std::ceil(claim.missed * kCases)) << size << ' ' << kind;
    }
  }
}

TEST_P(ThirdPartyContacts, DoNotPenetrateWhereTheBodiesAreApart) {
  distributions::Stream stream(2);
  int near = 0;
  constexpr int kCases = 100;
  for (int i = 0; i < kCases; ++i) {
    const bool is_ball_a = i % 2 == 0, is_ball_b = i % 4 < 2;
    const Case drawn = DrawCase(stream, is_ball_a, is_ball_b, 1, -stream.Uniform(0.001, 0.05));
    const auto contacts = ContactsOf(drawn, i % 8 < 4 ? CuboidAs::kHull : CuboidAs::kBox);
    for (const Contact& contact : contacts) EXPECT_GE(contact.distance, -1e-5);
    near += !contacts.empty();
  }
  if (GetParam().Makes(schema::KnownErrors::kNoNearContacts)) {
    EXPECT_EQ(near, 0);
  } else {
    EXPECT_GT(near, kCases / 4);
  }
}

TEST_P(ThirdPartyContacts, OfACuboidOnAFloorLieUnderIt) {
  const objects::Solid floor = {objects::Shape::kCuboid, Vector3d(20, 1, 20)};
  const objects::Solid box = {objects::Shape::kCuboid, Vector3d(1, 1, 1)};
  const Case drawn = {box, floor, {Vector3d(3, 0.995, -4)}, {Vector3d::Zero()}};
  for (const CuboidAs as : {CuboidAs::kBox, CuboidAs::kHull}) {
    const auto contacts = ContactsOf(drawn, as);
    ASSERT_FALSE(contacts.empty());
    for (const Contact& contact : contacts) {
      EXPECT_NEAR(contact.distance, -0.005, 1e-4);
      EXPECT_NEAR(contact.normal.y, 1, 1e-3);
      EXPECT_NEAR(contact.on_a.x, 3, 0.51);
      EXPECT_NEAR(contact.on_a.y, 0.495, 0.01);
      EXPECT_NEAR(contact.on_a.z, -4, 0.51);
      EXPECT_NEAR(contact.on_b.y, 0.5, 0.01);
    }
  }
}

// Bodies in the same place, one far larger than the other, or thin as a sheet: nothing crashes or
// hangs.
TEST_P(ThirdPartyContacts, ComeBackFromPosesWithoutAnAnswer) {
  distributions::Stream stream(3);
  const double sizes[] = {1e-3, 1, 1e3};
  for (const double size_a : sizes) {
    for (const double size_b : sizes) {
      for (int i = 0; i < 20; ++i) {
        Case drawn{Draw(stream, i % 2 == 0, size_a), Draw(stream, i % 4 < 2, size_b), {}, {}};
        if (i % 5 == 0 && !drawn.a.IsBall()) drawn.a.sides.y() *= 1e-4;
        drawn.pose_a.position = drawn.pose_b.position = Vector3d(1, 2, 3);
        if (i % 3 == 0) drawn.pose_b.orientation = stream.Turn();
        if (i % 7 == 0) drawn.pose_b.position += RandomDirection(stream) * size_b;
        ContactsOf(drawn, i % 8 < 4 ? CuboidAs::kHull : CuboidAs::kBox);
      }
    }
  }
}

TEST_P(ThirdPartyContacts, TakeEachPieceOfACompound) {
  const std::vector<Vec3> corners = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                     {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
  const std::vector<Face> faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                   {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                   {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  std::vector<Vec3> left = corners, right = corners;
  for (Vec3& corner : left) corner.x -= 3;
  for (Vec3& corner : right) corner.x += 3;
  const cdb::Hull hulls[] = {{left, faces}, {right, faces}};
  const cdb::Shape shapes[] = {
      {ShapeKind::kCompound, {4, 1, 1}, {0, 0, 0}, {}, hulls},
      {ShapeKind::kBox, {6, 1, 6}, {0, 0, 0}, {}, {}},
      {ShapeKind::kPlane, {INFINITY, INFINITY, INFINITY}, {0, 0, 0}, {0, 1, 0}, {}}};
  const Vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
  const cdb::Pose poses[] = {{{0, 1.99, 0}, x, y, z}, {{0, 0, 0}, x, y, z}, {{0, 0, 0}, x, y, z}};
  const cdb::Box boxes[] = {{{-4, 0.99, -1}, {4, 2.99, 1}},
                            {{-6, -1, -6}, {6, 1, 6}},
                            {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, 0, INFINITY}}};
  const Filter filters[3];
  const Scene scene = {.size = 3,
                       .boxes = boxes,
                       .filters = filters,
                       .poses = poses,
                       .shapes = shapes,
                       .is_asleep = {}};
  const auto detector = Make();
  detector->Prepare(scene);
  EXPECT_FALSE(detector->Handles(scene, 0, 2)) << "planes are Bullet's";
  ASSERT_TRUE(detector->Handles(scene, 0, 1));
  const Pair pair = {0, 1};
  std::vector<Contact> contacts;
  detector->FindContacts(scene, {&pair, 1}, contacts);
  int to_the_left = 0, to_the_right = 0;
  for (const Contact& contact : contacts) {
    EXPECT_NEAR(contact.distance, -0.01, 1e-4);
    to_the_left += contact.on_a.x < -1.9;
    to_the_right += contact.on_a.x > 1.9;
  }
  EXPECT_GE(to_the_left, 1);
  EXPECT_GE(to_the_right, 1);
  Scene boxes_alone = scene;
  boxes_alone.shapes = {};
  EXPECT_FALSE(detector->Handles(boxes_alone, 0, 1));
}

INSTANTIATE_TEST_SUITE_P(, ThirdPartyContacts, testing::ValuesIn(ThirdPartyDetectors("narrow")),
                         DetectorName());

}  // namespace
}  // namespace cdb::tests
