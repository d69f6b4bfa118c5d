// The points that `batch` finds for bodies that lie on each other, which pairs it takes, and that
// its contacts depend on the poses alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "library/detectors/narrow/batch.h"
#include "tests/library/detectors/narrow/pair_cases.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Shape;
using objects::Solid;

std::unique_ptr<Detector> MakeBatch() { return std::unique_ptr<Detector>(narrow::MakeBatch({})); }

std::vector<Contact> ContactsOf(const PairCase& pair) {
  const PairScene bodies({pair});
  const auto batch = MakeBatch();
  batch->Prepare(bodies.View());
  std::vector<Contact> contacts;
  if (batch->Handles(bodies.View(), 0, 1))
    batch->FindContacts(bodies.View(), bodies.pairs(), contacts);
  return contacts;
}

Eigen::Quaterniond Turned(double angle, const Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
}

/// On top of a body whose upper side is at y = 0.
PairCase OnTop(const Solid& upper, double height, const Eigen::Quaterniond& turn,
               const Solid& lower, double lower_height) {
  return {upper, lower, {Vector3d(0.1, height, 0.2), turn}, {Vector3d(0, -lower_height, 0)}};
}

/// All points are this deep, and their area in the plane of x and z is at least this.
void ExpectManifold(const std::vector<Contact>& contacts, std::size_t count, double distance,
                    double area, double tolerance = 1e-9) {
  ASSERT_EQ(contacts.size(), count);
  std::vector<Vector3d> corners;
  for (const Contact& contact : contacts) {
    EXPECT_NEAR(contact.distance, distance, tolerance);
    EXPECT_NEAR(contact.normal.y, 1, tolerance);
    corners.emplace_back(contact.on_b.x, 0, contact.on_b.z);
  }
  double widest = 0;
  for (const Vector3d& a : corners)
    for (const Vector3d& b : corners)
      for (const Vector3d& c : corners)
        widest = std::max(widest, (b - a).cross(c - a).norm());  // of two triangles
  EXPECT_GE(widest, area);
}

const Solid kBox{Shape::kCuboid, Vector3d(1, 1, 1)}, kFloor{Shape::kCuboid, Vector3d(9, 2, 9)};

TEST(Manifold, OfABoxOnABoxHasFourPoints) {
  for (const double depth : {-0.01, 0.0, 0.001, 0.1}) {
    ExpectManifold(ContactsOf(OnTop(kBox, 0.5 - depth, Turned(0.3, Vector3d::UnitY()), kFloor, 1)),
                   4, -depth, 0.99);
    const Solid plate{Shape::kCuboid, Vector3d(1, 2, 1)};
    // The faces intersect in an octagon.
    PairCase octagon = OnTop(kBox, 0.5 - depth, Turned(M_PI / 4, Vector3d::UnitY()), plate, 1);
    octagon.pose_a.position.x() = octagon.pose_a.position.z() = 0;
    ExpectManifold(ContactsOf(octagon), 4, -depth, 0.58);
  }
}

TEST(Manifold, OfATiltedBoxHasThePointsThatAreNear) {
  PairCase pair = OnTop(kBox, 0, Turned(0.5, Vector3d::UnitX()), kFloor, 1);
  MoveToGap(pair, -0.001);
  const auto contacts = ContactsOf(pair);
  ASSERT_EQ(contacts.size(), 2u) << "an edge";
  for (const Contact& contact : contacts) EXPECT_NEAR(contact.distance, -0.001, 1e-9);
}

TEST(Manifold, OfAHullOnABoxHasTheDeepestPoint) {
  const Solid ball = RoundHull(64, 1);
  PairCase pair = OnTop(ball, 0.6, {1, 0, 0, 0}, kFloor, 1);
  MoveToGap(pair, -0.002);
  const auto contacts = ContactsOf(pair);
  ASSERT_FALSE(contacts.empty());
  EXPECT_LE(contacts.size(), 4u);
  const auto deepest = std::ranges::min_element(contacts, {}, &Contact::distance);
  EXPECT_NEAR(deepest->distance, -0.002, 1e-6);
}

TEST(Manifold, OfABoxOrACapsuleOnAPlaneHasAllItsLowPoints) {
  const Solid capsule{Shape::kCapsule, Vector3d(0.4, 2, 0.4)};
  PairCase on_plane{kBox, kBox, {Vector3d(3, 0.49, 1)}, {}, true};
  ExpectManifold(ContactsOf(on_plane), 4, -0.01, 0.99);
  const Eigen::Quaterniond lying = Turned(M_PI / 2, Vector3d::UnitX());
  PairCase capsule_on_plane{capsule, kBox, {Vector3d(3, 0.19, 1), lying}, {}, true};
  ExpectManifold(ContactsOf(capsule_on_plane), 2, -0.01, 0);
  ExpectManifold(ContactsOf(OnTop(capsule, 0.19, lying, kFloor, 1)), 2, -0.01, 0);
  PairCase on_capsule = OnTop(capsule, 0.39, lying, capsule, 0);
  on_capsule.pose_a.position.x() = 0;
  on_capsule.pose_b.orientation = lying;
  ExpectManifold(ContactsOf(on_capsule), 2, -0.01, 0);
  capsule_on_plane.pose_a = {Vector3d(0, 0.99, 0)};
  ExpectManifold(ContactsOf(capsule_on_plane), 1, -0.01, 0);
}

const Solid kCylinder{Shape::kCylinder, Vector3d(1, 2, 1)}, kCone{Shape::kCone, Vector3d(1, 2, 1)};

/// On a plane and on a box; the height is that of the upper body's centre of mass above contact.
void ExpectOnFloors(const Solid& upper, double height, const Eigen::Quaterniond& turn,
                    std::size_t count, double area) {
  for (const double depth : {-0.005, 0.0, 0.01}) {
    PairCase on_plane{upper, kBox, {Vector3d(3, height - depth, 1), turn}, {}, true};
    ExpectManifold(ContactsOf(on_plane), count, -depth, area, 2e-7);
    ExpectManifold(ContactsOf(OnTop(upper, height - depth, turn, kFloor, 1)), count, -depth, area,
                   2e-7);
  }
}

TEST(Manifold, OfABaseOnAFloorHasFourPointsOnItsRim) {
  // A square in a circle of diameter 1.
  ExpectOnFloors(kCylinder, 1, Turned(0.3, Vector3d::UnitY()), 4, 0.49);
  ExpectOnFloors(kCylinder, 1, Turned(M_PI, Vector3d::UnitX()), 4, 0.49);
  ExpectOnFloors(kCone, 0.5, Turned(0.3, Vector3d::UnitY()), 4, 0.49);
  // Of a small plate, the corners; of a cylinder that stands over its edge, the part on it.
  const Solid plate{Shape::kCuboid, Vector3d(0.4, 2, 0.4)};
  PairCase on_plate = OnTop(kCylinder, 0.99, {1, 0, 0, 0}, plate, 1);
  ExpectManifold(ContactsOf(on_plate), 4, -0.01, 0.159);
  on_plate.pose_a.position.x() = 0.5;
  ExpectManifold(ContactsOf(on_plate), 4, -0.01, 0.05);
}

TEST(Manifold, OfARoundSideOnAFloorHasTheEndsOfALine) {
  const Eigen::Quaterniond lying = Turned(M_PI / 2, Vector3d::UnitX());
  ExpectOnFloors(kCylinder, 0.5, lying, 2, 0);
  // The cone lies on its side; its centre of mass is a quarter of the height above the base.
  const double half_angle = std::atan(0.25), height = 1.5 * std::sin(half_angle);
  ExpectOnFloors(kCone, height, Turned(M_PI / 2 + half_angle, Vector3d::UnitX()), 2, 0);
  PairCase on_cylinder = OnTop(kCylinder, 0.99, lying, kCylinder, 0);
  on_cylinder.pose_a.position.x() = 0;
  on_cylinder.pose_b.orientation = lying;
  ExpectManifold(ContactsOf(on_cylinder), 2, -0.01, 0, 2e-7);
  on_cylinder.pose_b.orientation = Turned(M_PI / 2, Vector3d::UnitZ());
  ExpectManifold(ContactsOf(on_cylinder), 1, -0.01, 0, 2e-7);
}

TEST(Manifold, OfATiltedCylinderHasTheDeepestPoint) {
  for (const double tilt : {1e-7, 1e-4, 0.01, 0.3, 1.0}) {
    PairCase pair = OnTop(kCylinder, 1, Turned(tilt, Vector3d(0.6, 0, 0.8)), kFloor, 1);
    MoveToGap(pair, -0.001);
    const auto contacts = ContactsOf(pair);
    ASSERT_FALSE(contacts.empty());
    EXPECT_LE(contacts.size(), 4u);
    EXPECT_EQ(contacts.size() == 1, tilt > 0.1) << tilt;
    EXPECT_NEAR(std::ranges::min_element(contacts, {}, &Contact::distance)->distance, -0.001, 1e-6);
  }
}

TEST(Batch, LeavesOtherShapesToBullet) {
  EXPECT_FALSE(ContactsOf({kBox, kBox, {}, {}}).empty());
  const Solid ellipsoid{Shape::kEllipsoid, Vector3d(1, 2, 1)},
      flat_capsule{Shape::kCapsule, Vector3d(1, 3, 2)};
  for (const Solid& other : {kCylinder, kCone, ellipsoid, flat_capsule}) {
    EXPECT_FALSE(ContactsOf({kBox, other, {}, {}}).empty());
    EXPECT_FALSE(ContactsOf({other, kBox, {}, {}, true}).empty());
  }
  distributions::Stream stream(2);
  const Solid torus = RandomBody(stream, Type::kCompound, 1, false);
  EXPECT_TRUE(ContactsOf({torus, torus, {}, {}}).empty());
  const Solid super{Shape::kSuperellipsoid, Vector3d(1, 2, 1), nullptr, {0.5, 0.5}};
  EXPECT_TRUE(ContactsOf({kBox, super, {}, {}}).empty());
  EXPECT_FALSE(ContactsOf({torus, kBox, {}, {}}).empty());
  const PairScene bodies({PairCase{kBox, kBox, {}, {}}});
  Scene without_shapes = bodies.View();
  without_shapes.shapes = {};
  const auto batch = MakeBatch();
  batch->Prepare(without_shapes);
  EXPECT_FALSE(batch->Handles(without_shapes, 0, 1));
}

std::vector<PairCase> RandomPairs(int count) {
  distributions::Stream stream(11);
  constexpr Type kTypes[] = {Type::kBall,     Type::kCapsule, Type::kBox,       Type::kHull,
                             Type::kCylinder, Type::kCone,    Type::kEllipsoid, Type::kCompound};
  std::vector<PairCase> pairs;
  for (int i = 0; i < count; ++i)  // but for two compounds
    pairs.push_back(RandomPair(stream, kTypes[i % 8], kTypes[i / 8 % 7]));
  return pairs;
}

/// Sorted by pair; the points of a pair stay in order.
std::vector<Contact> SortedContacts(Detector& batch, const Scene& scene,
                                    std::span<const Pair> pairs) {
  std::vector<Contact> contacts;
  batch.FindContacts(scene, pairs, contacts);
  std::ranges::stable_sort(contacts, {}, &Contact::a);
  return contacts;
}

bool AreSame(const std::vector<Contact>& a, const std::vector<Contact>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

TEST(Batch, GivesTheSameBitsWhateverTheOrderOfPairsAndEarlierCycles) {
  const PairScene bodies(RandomPairs(500));
  const Scene scene = bodies.View();
  const auto batch = MakeBatch(), other = MakeBatch();
  batch->Prepare(scene);
  other->Prepare(scene);
  const auto contacts = SortedContacts(*batch, scene, bodies.pairs());
  EXPECT_GT(contacts.size(), 500u);
  EXPECT_TRUE(AreSame(SortedContacts(*batch, scene, bodies.pairs()), contacts)) << "warm";
  // Bodies come from somewhere else, and some pairs are new.
  std::vector<Pose> moved(scene.poses.begin(), scene.poses.end());
  for (std::size_t i = 0; i < moved.size(); i += 2) moved[i].position.x += 0.03;
  Scene before = scene;
  before.poses = moved;
  SortedContacts(*other, before, std::span(bodies.pairs()).subspan(100));
  std::vector<Pair> reversed(bodies.pairs().rbegin(), bodies.pairs().rend());
  EXPECT_TRUE(AreSame(SortedContacts(*other, scene, reversed), contacts));
  other->Prepare(scene);
  EXPECT_TRUE(AreSame(SortedContacts(*other, scene, reversed), contacts)) << "another run";
}

TEST(Batch, RemembersNothingThatChangesAContact) {
  // Bodies that slide, roll, and come apart and together again: each cycle as if it were the first.
  distributions::Stream stream(17);
  constexpr Type kTypes[] = {Type::kHull, Type::kBox, Type::kTetrahedron, Type::kCapsule,
                             Type::kBall};
  std::vector<PairCase> pairs;
  constexpr int kPolytopes = 400, kOfCurved = 440;
  for (int i = 0; i < kPolytopes; ++i)
    pairs.push_back(RandomPair(stream, kTypes[i % 3], kTypes[i / 3 % 5]));
  constexpr Type kCurved[] = {Type::kCylinder, Type::kCone, Type::kEllipsoid, Type::kFlatCapsule};
  for (int i = 0; i < 400; ++i)
    pairs.push_back(
        RandomPair(stream, kCurved[i % 4], i % 3 == 0 ? kCurved[i / 3 % 4] : kTypes[i / 3 % 5]));
  for (int i = 0; i < 20; ++i)  // that stand or lie on a face
    for (const Shape shape : {Shape::kCylinder, Shape::kCone}) {
      const bool lies = i % 2 == 1;
      const Eigen::Quaterniond turn =
          Turned(0.1 * i, {0, 1, 0}) * Turned(lies ? M_PI / 2 : 0, {1, 0, 0});
      pairs.push_back(OnTop({shape, Vector3d(0.5, 1, 0.5)}, lies ? 0.249 : 0.499, turn, kFloor, 1));
    }
  for (int i = 0; i < 20; ++i)  // that lie on each other
    pairs.push_back(OnTop(RandomBody(stream, Type::kBox, 1, false), 0.5, Turned(0.1 * i, {0, 1, 0}),
                          RoundHull(16, 1), 0.4));
  const PairScene bodies(pairs);
  Scene scene = bodies.View();
  std::vector<Pose> poses(scene.poses.begin(), scene.poses.end());
  scene.poses = poses;
  const auto batch = MakeBatch();
  batch->Prepare(scene);
  // Of two ways out that are about as long, a search may find the other one.
  std::size_t found = 0, others = 0;
  for (int cycle = 0; cycle < Cases(100); ++cycle) {
    const auto fresh = MakeBatch();
    fresh->Prepare(scene);
    const auto expected = SortedContacts(*fresh, scene, bodies.pairs());
    const auto contacts = SortedContacts(*batch, scene, bodies.pairs());
    for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
      const auto of_pair = [&](const std::vector<Contact>& all) {
        return std::ranges::equal_range(all, 2 * pair, {}, &Contact::a);
      };
      const auto got = of_pair(contacts), wanted = of_pair(expected);
      if (std::ranges::equal(got, wanted, [](const Contact& one, const Contact& other) {
            return std::memcmp(&one, &other, sizeof one) == 0;
          }))
        continue;
      ++others;
      ASSERT_TRUE(pair >= kPolytopes && pair < kPolytopes + kOfCurved)
          << cycle << ": pair " << pair;
      ASSERT_FALSE(got.empty() || wanted.empty()) << cycle << ": pair " << pair;
      const double depth = std::ranges::min(wanted, {}, &Contact::distance).distance;
      ASSERT_NEAR(std::ranges::min(got, {}, &Contact::distance).distance, depth,
                  0.01 * std::abs(depth))
          << cycle << ": pair " << pair;
    }
    found += expected.size();
    for (std::size_t i = 0; i < poses.size(); i += 2) {
      Pose& pose = poses[i];
      const double size = pairs[i / 2].a.sides.minCoeff(), angle = stream.Uniform(-0.004, 0.004);
      const Vec3 x = pose.x, y = pose.y;
      const double c = std::cos(angle), s = std::sin(angle);
      if (i % 4 == 0) {
        pose.x = {c * x.x + s * y.x, c * x.y + s * y.y, c * x.z + s * y.z};
        pose.y = {c * y.x - s * x.x, c * y.y - s * x.y, c * y.z - s * x.z};
      }
      pose.position.x += size * stream.Uniform(-0.01, 0.01);
      pose.position.y += size * stream.Uniform(-0.01, 0.01);
    }
  }
  EXPECT_GT(found, 200u * static_cast<std::size_t>(Cases(100)));
  EXPECT_LE(others, 1 + found / 50000);
}

TEST(Batch, GivesTheSameContactsInTheSameOrderWithAnyNumberOfThreads) {
  const PairScene bodies(RandomPairs(3000));  // enough to be shared
  Scene scene = bodies.View();
  std::vector<Pose> poses(scene.poses.begin(), scene.poses.end());
  scene.poses = poses;
  std::vector<std::unique_ptr<Detector>> all;
  for (const unsigned threads : {1, 2, 3}) {
    all.emplace_back(narrow::MakeBatch({.threads = threads}));
    all.back()->Prepare(scene);
  }
  for (std::size_t cycle = 0; cycle < 4; ++cycle) {
    // The parts of the pairs begin elsewhere in each cycle, and hints are of other poses.
    const auto pairs = std::span(bodies.pairs()).subspan(7 * cycle);
    std::vector<Contact> expected;
    for (const auto& batch : all) {
      std::vector<Contact> contacts;
      batch->FindContacts(scene, pairs, contacts);
      if (batch == all.front()) expected = contacts;
      EXPECT_TRUE(AreSame(contacts, expected)) << cycle;
    }
    EXPECT_GT(expected.size(), 3000u);
    for (std::size_t i = 0; i < poses.size(); i += 2) poses[i].position.y += 0.001;
  }
}

TEST(Batch, FindsNoContactsOfPosesThatAreNotFinite) {
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
    for (PairCase pair : RandomPairs(50)) {
      const PairScene bodies({pair});
      Scene scene = bodies.View();
      std::vector<Pose> poses(scene.poses.begin(), scene.poses.end());
      poses[0].position.y = value;
      if (value < 1e300) poses[0].x = {value, value, value};
      scene.poses = poses;
      const auto batch = MakeBatch();
      batch->Prepare(scene);
      std::vector<Contact> contacts;
      batch->FindContacts(scene, bodies.pairs(), contacts);
      for (const Contact& contact : contacts) EXPECT_TRUE(std::isfinite(contact.distance));
    }
  }
}

TEST(Batch, MirrorsThePairWhenItsBodiesAreSwapped) {
  const std::vector<PairCase> pairs = RandomPairs(200);
  for (const PairCase& pair : pairs) {
    const auto contacts = ContactsOf(pair),
               swapped = ContactsOf({pair.b, pair.a, pair.pose_b, pair.pose_a});
    ASSERT_EQ(contacts.empty(), swapped.empty());
    if (contacts.empty()) continue;
    const auto least = [](const std::vector<Contact>& all) {
      return std::ranges::min_element(all, {}, &Contact::distance)->distance;
    };
    EXPECT_NEAR(least(contacts), least(swapped), 1e-9 * pair.a.sides.maxCoeff());
  }
}

}  // namespace
}  // namespace cdb::tests
