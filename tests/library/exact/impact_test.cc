// Where solids touch, and the velocities after an impact, against closed forms.
#include "library/exact/impact.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using exact::ImpactBody;
using exact::ImpactContact;
using exact::Slip;
using objects::Shape;
using objects::Solid;

const Solid kBall{Shape::kEllipsoid, Vector3d::Ones()};
const Solid kCube{Shape::kCuboid, Vector3d::Ones()};
const Solid kDisc{Shape::kCylinder, Vector3d(1, 0.5, 1)};

exact::Motion Moving(const Vector3d& from, const Vector3d& way) {
  exact::Motion motion;
  motion.from.position = from;
  motion.way = way;
  return motion;
}

exact::Collider At(const Solid& solid, const Vector3d& position) {
  return {&solid, Moving(position, Vector3d::Zero())};
}

ImpactBody Body(const Solid& solid, double mass, const Vector3d& centre, const Vector3d& velocity) {
  return {1 / mass, (mass * solid.InertiaPerMass()).cwiseInverse().asDiagonal(), centre, velocity,
          Vector3d::Zero()};
}

TEST(Touch, OfBallsIsWhereTheirDistanceIsTheSumOfRadii) {
  for (const double offset : {0.0, 0.3, 0.8}) {
    // At part 0 they overlap; the touch was before.
    const exact::Motion motion = Moving({-0.5, offset, 0}, {0.4, 0, 0});
    const auto touch = exact::FindTouch(kBall, motion, At(kBall, Vector3d::Zero()), -3, 2);
    ASSERT_TRUE(touch);
    const double x = -std::sqrt(1 - offset * offset);
    EXPECT_NEAR(touch->part, (x + 0.5) / 0.4, 1e-3);
    EXPECT_LT((touch->normal - Vector3d(x, offset, 0)).norm(), 1e-3);
    EXPECT_LT((touch->point - Vector3d(x, offset, 0) / 2).norm(), 1e-3);
  }
  // They pass each other; they overlap at the first part; the touch is later.
  for (const auto& [offset, from, to] :
       {std::tuple(1.1, -3., 2.), {0.3, -0.5, 2.}, {0.3, -3., -2.}})
    EXPECT_FALSE(exact::FindTouch(kBall, Moving({-0.5, offset, 0}, {0.4, 0, 0}),
                                  At(kBall, Vector3d::Zero()), from, to));
}

TEST(Touch, OfASolidThatTurns) {
  exact::Motion motion = Moving({0, 0.8, 0}, {0, -0.1, 0});
  motion.turn = {0, 0, 0.2};
  const auto touch = exact::FindTouch(kCube, motion, {}, -3, 5);
  ASSERT_TRUE(touch);
  const double angle = 0.2 * touch->part;
  EXPECT_NEAR(0.8 - 0.1 * touch->part, (std::cos(angle) + std::abs(std::sin(angle))) / 2, 1e-3);
  EXPECT_LT((touch->normal - Vector3d::UnitY()).norm(), 1e-9);
}

TEST(ContactRegion, IsAPointALineOrAFace) {
  const auto corners = [](const Solid& a, const Vector3d& from, const Solid& b, double tilt,
                          double turned) {
    exact::Motion motion = Moving(from, -0.1 * from);
    motion.from.orientation = Eigen::AngleAxisd(turned, Vector3d::UnitZ());
    const exact::Collider other = At(b, Vector3d::Zero());
    const auto touch = exact::FindTouch(a, motion, other, 0, 10);
    EXPECT_TRUE(touch);
    return exact::ContactRegion(a, motion.At(touch->part), &b, other.motion.from, *touch, tilt);
  };
  double largest = 0;
  for (const Vector3d& corner : corners(kCube, {0, 2, 0}, kCube, 0.01, 0))
    for (const Vector3d& other : corners(kCube, {0, 2, 0}, kCube, 0.01, 0))
      largest = std::max(largest, (corner - other).norm());
  EXPECT_NEAR(largest, std::sqrt(2), 0.01);
  // A cube that is turned by more than the tilt touches with an edge.
  for (const Vector3d& corner : corners(kCube, {0, 2, 0}, kCube, 0.01, 0.05))
    EXPECT_NEAR(std::abs(corner.z()), 0.5, 0.01);
  double lowest = 0, highest = 0;
  for (const Vector3d& corner : corners(kDisc, {2, 0, 0}, kDisc, 0.01, 0.002)) {
    lowest = std::min(lowest, corner.y());
    highest = std::max(highest, corner.y());
    EXPECT_NEAR(corner.z(), 0, 0.01);
  }
  EXPECT_NEAR(lowest, -0.25, 0.01);
  EXPECT_NEAR(highest, 0.25, 0.01);
  EXPECT_EQ(corners(kBall, {2, 0, 0}, kBall, 1e-3, 0).size(), 1u);
}

TEST(SolveImpact, PartsBallsAlongTheLineOfTheirCentres) {
  for (const double restitution : {0.0, 0.5, 1.0})
    for (const double mass : {0.5, 1.0, 3.0}) {
      const Vector3d normal = Vector3d(-0.8, 0.6, 0);
      ImpactBody bodies[] = {Body(kBall, 1, normal, {4, 0, 0}),
                             Body(kBall, mass, Vector3d::Zero(), Vector3d::Zero())};
      const ImpactContact contact{0, 1, normal, normal / 2, 0, restitution * 3.2};
      exact::SolveImpact(bodies, {&contact, 1}, Slip::kLeft);
      const double impulse = (1 + restitution) * 3.2 / (1 + 1 / mass);
      EXPECT_LT((bodies[0].velocity - Vector3d(4, 0, 0) - impulse * normal).norm(), 1e-9);
      EXPECT_LT((bodies[1].velocity + impulse / mass * normal).norm(), 1e-9);
      EXPECT_LT(bodies[0].spin.norm() + bodies[1].spin.norm(), 1e-9);
    }
}

TEST(SolveImpact, SlidesOrRollsABall) {
  // With restitution e, a ball slides along a wall if mu < 2 v_t / (7 (1 + e) v_n).
  for (const Slip slip : {Slip::kLeft, Slip::kFirst})
    for (const double friction : {0.05, 0.1, 0.5, 2.0}) {
      ImpactBody bodies[] = {Body(kBall, 2, {0, 0.5, 0}, {3, -2, 0}), {}};
      const ImpactContact contact{0, 1, Vector3d::UnitY(), Vector3d::Zero(), friction, 0.5 * 2};
      exact::SolveImpact(bodies, {&contact, 1}, slip);
      const double change = std::min(friction * 3, 2. / 7 * 3);
      EXPECT_LT((bodies[0].velocity - Vector3d(3 - change, 1, 0)).norm(), 1e-6) << friction;
      EXPECT_NEAR(bodies[0].spin.z(), -change * 0.5 / 0.1, 1e-6);
    }
}

TEST(SolveImpact, DoesNotTurnACubeThatLandsFlat) {
  ImpactBody bodies[] = {Body(kCube, 1, {0, 0.5, 0}, {0, -3, 0}), {}};
  std::vector<ImpactContact> contacts;
  for (const double x : {-0.5, 0.5})
    for (const double z : {-0.5, 0.5})
      contacts.push_back({0, 1, Vector3d::UnitY(), {x, 0, z}, 0.5, 0.4 * 3});
  exact::SolveImpact(bodies, contacts, Slip::kLeft);
  EXPECT_LT((bodies[0].velocity - Vector3d(0, 1.2, 0)).norm(), 1e-4);
  EXPECT_LT(bodies[0].spin.norm(), 1e-4);
}

TEST(SolveImpact, KeepsMomentaAndLosesEnergy) {
  // Two cubes, corner to face: friction in any direction.
  for (const double friction : {0.0, 0.2, 1.0}) {
    const Vector3d normal = Vector3d(-0.9, 0.3, 0.3).normalized(), point(0.1, 0.2, -0.1);
    ImpactBody bodies[] = {Body(kCube, 1, {-0.6, 0.3, 0.2}, {4, 1, 0}),
                           Body(kCube, 2, {0.6, 0.1, -0.3}, {0, 0, 1})};
    const auto momenta = [&] {
      Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
      double energy = 0;
      for (const ImpactBody& body : bodies) {
        const Vector3d own = body.inverse_inertia.inverse() * body.spin;
        linear += body.velocity / body.inverse_mass;
        angular += body.centre.cross(body.velocity) / body.inverse_mass + own;
        energy += body.velocity.squaredNorm() / body.inverse_mass + body.spin.dot(own);
      }
      return std::tuple(linear, angular, energy);
    };
    const auto [linear, angular, energy] = momenta();
    const ImpactContact contact{0, 1, normal, point, friction, 1};
    exact::SolveImpact(bodies, {&contact, 1}, Slip::kLeft);
    const auto [linear_after, angular_after, energy_after] = momenta();
    EXPECT_LT((linear - linear_after).norm() + (angular - angular_after).norm(), 1e-9);
    EXPECT_LT(energy_after, energy);
    const Vector3d left = exact::VelocityAt(bodies[0], point) - exact::VelocityAt(bodies[1], point);
    EXPECT_NEAR(left.dot(normal), 1, 1e-6);
    // Friction is against the sliding that is left.
    const Vector3d impulse = bodies[0].velocity - Vector3d(4, 1, 0);
    const Vector3d across = impulse - impulse.dot(normal) * normal,
                   sliding = left - left.dot(normal) * normal;
    EXPECT_LE(across.norm(), friction * impulse.dot(normal) + 1e-9);
    if (sliding.norm() > 1e-6 && friction > 0) {
      EXPECT_LT(across.normalized().dot(sliding.normalized()), -0.999) << friction;
    }
  }
}

TEST(ImpactCourse, FollowsTheEdgesOfACubeInTurn) {
  for (const double e : {0., 0.5, 1.})
    for (const double tilt : {0.01, 0.04, 0.1}) {
      SCOPED_TRACE(testing::Message() << "e = " << e << ", tilt " << tilt);
      exact::ImpactCourse::Body cube;
      cube.solid = &kCube;
      cube.pose.orientation = Eigen::AngleAxisd(tilt, Vector3d::UnitZ());
      cube.mass = 2;
      cube.inertia = cube.mass * kCube.InertiaPerMass();
      cube.velocity = Vector3d(0, -1, 0);
      // The lower edge is on the left; its height below the centre and its distance from it.
      const double height = (std::cos(tilt) + std::sin(tilt)) / 2,
                   beside = (std::cos(tilt) - std::sin(tilt)) / 2;
      cube.pose.position.y() = height;
      exact::ImpactCourse course(cube, {},
                                 {0, e, Vector3d::Zero(), Slip::kLeft, {Vector3d::UnitY(), 0}});
      // An impulse J beside the centre changes v by J / m, and the spin by J x / I.
      const double inertia = kCube.InertiaPerMass().z();
      const double change = (1 + e) / (1 + beside * beside / inertia);
      course.Advance(1e-4, 1);
      EXPECT_NEAR(course.a().velocity.y(), -1 + change, 2e-3);
      EXPECT_NEAR(course.a().spin.z(), -beside * change / inertia, 1e-2);
      // The other edge follows: nothing approaches any more, and no energy is gained.
      course.Advance(1, 2000);
      EXPECT_GT(course.a().velocity.y() + std::abs(course.a().spin.z()), -1e-3);
      EXPECT_LT(course.a().velocity.squaredNorm() + inertia * course.a().spin.squaredNorm(),
                1 + 1e-3);
      if (e == 1) {
        EXPECT_NEAR(course.a().velocity.squaredNorm() + inertia * course.a().spin.squaredNorm(), 1,
                    1e-3);
      }
    }
}

}  // namespace
}  // namespace cdb::tests
