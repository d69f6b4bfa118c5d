#include "runtime/omissions/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/runtime/omissions/hand_made_scene.h"
#include "tests/runtime/omissions/random.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using layouts::ObjectState;

/// Bullet's position of the object at the start of each cycle, in numbers of type T, as its
/// btRigidBody and solver compute it.
template <typename T>
std::vector<Vector3d> PlacesOf(const ObjectState& object, const Vector3d& acceleration,
                               const omissions::Horizon& horizon) {
  using Vector = Eigen::Matrix<T, 3, 1>;
  Vector x = object.pose.position.cast<T>(), v = object.linear_velocity.cast<T>();
  const T dt = static_cast<T>(horizon.timestep);
  const T inverse_mass = 1 / static_cast<T>(object.mass);
  const Vector force = acceleration.cast<T>() * (1 / inverse_mass);
  const T kept = std::pow(1 - static_cast<T>(object.numbers["linear_damping"]), dt);
  std::vector<Vector3d> places;
  for (double step = 0; step < horizon.steps; ++step) {
    places.push_back(x.template cast<double>());
    v *= kept;
    v += force * inverse_mass * dt;
    x += v * dt;
  }
  return places;
}

bool IsWithin(const omissions::Box& box, const Vector3d& place, const Vector3d& slack) {
  return (place.array() >= (box.min() - slack).array()).all() &&
         (place.array() <= (box.max() + slack).array()).all();
}

TEST(Trajectory, RoundingStaysWithinTheSlack) {
  Random random(1);
  double largest = 0;
  for (const char* precision : {"single", "double"}) {
    for (int round = 0; round < Cases(300); ++round) {
      HandMade scene;
      scene.Set("precision", Word(precision));
      scene.Set("timestep", random(0.001, 0.1));
      scene.Set("cycles", static_cast<std::uint64_t>(random(1, 3000)));
      scene.Add(random.Vector(std::pow(10, random(0, 5))), random.Vector(100));
      const Vector3d g = round % 3 == 0 ? Vector3d(Vector3d::Zero()) : random.Vector(10);
      const ObjectState& object = scene.state.objects[0];
      const omissions::Horizon horizon = omissions::HorizonOf(scene.scene);
      const omissions::Trajectory trajectory =
          omissions::TrajectoryOf(object, g, scene.scene, horizon);
      ASSERT_EQ(trajectory.motion, omissions::Motion::kFree);
      const auto places = *precision == 's' ? PlacesOf<float>(object, g, horizon)
                                            : PlacesOf<double>(object, g, horizon);
      const omissions::Box path = trajectory.PathUntil(horizon.end);
      for (std::size_t step = 0; step < places.size(); ++step) {
        const double time = static_cast<double>(step) * horizon.timestep;
        const Vector3d error = (places[step] - trajectory.PlaceAt(time)).cwiseAbs();
        ASSERT_TRUE((error.array() <= trajectory.slack.array()).all())
            << error.transpose() << " against " << trajectory.slack.transpose();
        ASSERT_TRUE(IsWithin(path, places[step], trajectory.slack));
        largest = std::max(largest, error.cwiseQuotient(trajectory.slack).maxCoeff());
      }
    }
  }
  // The slack is not excessive either.
  EXPECT_GT(largest, 0.01);
}

TEST(Trajectory, SlowedObjectsStayInTheirBox) {
  Random random(2);
  for (int round = 0; round < Cases(500); ++round) {
    HandMade scene;
    scene.Set("cycles", std::uint64_t{200});
    scene.Add(random.Vector(10), random.Vector(10));
    ObjectState& object = scene.state.objects[0];
    object.numbers["linear_damping"] = round % 5 == 0 ? 1 : random(0.01, 1);
    const Vector3d g = random.Vector(10);
    const omissions::Horizon horizon = omissions::HorizonOf(scene.scene);
    const omissions::Trajectory trajectory =
        omissions::TrajectoryOf(object, g, scene.scene, horizon);
    ASSERT_EQ(trajectory.motion, omissions::Motion::kSlowed);
    const auto places = PlacesOf<double>(object, g, horizon);
    for (std::size_t step = 0; step < places.size(); ++step) {
      const double time = static_cast<double>(step) * horizon.timestep;
      ASSERT_TRUE(IsWithin(trajectory.PathUntil(time), places[step], trajectory.slack)) << step;
      ASSERT_TRUE(IsWithin(trajectory.FallingPathUntil(time, g),
                           places[step] - omissions::FallUntil(g, horizon.timestep, time),
                           trajectory.slack));
    }
  }
}

TEST(Trajectory, HoldsTheSolidHoweverItIsTurned) {
  Random random(3);
  for (const objects::Shape shape :
       {objects::Shape::kEllipsoid, objects::Shape::kCuboid, objects::Shape::kCylinder,
        objects::Shape::kCone, objects::Shape::kCapsule, objects::Shape::kTetrahedron}) {
    for (int round = 0; round < Cases(100); ++round) {
      HandMade scene;
      scene.Add(Vector3d::Zero());
      ObjectState& object = scene.state.objects[0];
      object.solid = {shape, Vector3d{random(0.1, 4), random(0.1, 4), random(0.1, 4)}};
      object.pose.orientation = layouts::TurnAbout(random.Vector(3));
      object.numbers["margin"] = 0.04;
      const omissions::Horizon horizon = omissions::HorizonOf(scene.scene);
      const omissions::Trajectory still =
          omissions::TrajectoryOf(object, Vector3d::Zero(), scene.scene, horizon);
      object.angular_velocity = Vector3d(0, 0, 1e-3);
      const omissions::Trajectory spinning =
          omissions::TrajectoryOf(object, Vector3d::Zero(), scene.scene, horizon);
      EXPECT_EQ(spinning.extent, Vector3d(Vector3d::Constant(spinning.radius)));
      double farthest = 0;
      for (int ray = 0; ray < Cases(300); ++ray) {
        const Vector3d point = object.solid.Support(random.Vector(1));
        farthest = std::max(farthest, point.norm());
        const Vector3d turned = object.pose.orientation * point;
        EXPECT_TRUE((turned.cwiseAbs().array() <= still.extent.array()).all());
      }
      EXPECT_LE(farthest, spinning.radius);
      EXPECT_GT(farthest + object.numbers["margin"], 0.9 * spinning.radius);
    }
  }
}

TEST(Trajectory, BallsHaveNoMargin) {
  HandMade scene;
  scene.Add(Vector3d::Zero());
  scene.state.objects[0].numbers["margin"] = 0.04;
  const omissions::Trajectory trajectory = omissions::TrajectoryOf(
      scene.state.objects[0], Vector3d::Zero(), scene.scene, omissions::HorizonOf(scene.scene));
  EXPECT_EQ(trajectory.radius, 1);
  EXPECT_DOUBLE_EQ(trajectory.threshold, kThreshold);
}

/// The first time within touching distance, and the smallest gap, by sampling 20000 times.
TEST(Trajectory, ClosestApproachIsThatOfTheWay) {
  Random random(4);
  int meetings = 0, escapes = 0;
  for (int round = 0; round < Cases(600); ++round) {
    HandMade scene;
    scene.Set("cycles", static_cast<std::uint64_t>(random(1, 200)));
    const Vector3d g = round % 3 == 0 ? Vector3d(0, -9.8, 0)
                                      : Vector3d(random.Vector(std::pow(10, random(-9, 2))));
    const omissions::Horizon horizon = omissions::HorizonOf(scene.scene);
    scene.Add(random.Vector(10), random.Vector(10));
    const auto trajectory = [&](std::size_t i) {
      return omissions::TrajectoryOf(scene.state.objects[i], g, scene.scene, horizon);
    };
    // Makes them come close to each other at some time.
    const bool is_fixed = round % 2 == 0;
    const Vector3d velocity = is_fixed ? Vector3d(Vector3d::Zero()) : random.Vector(10);
    const double when = random(0, 1.2) * horizon.end;
    const Vector3d fall = omissions::FallUntil(g, horizon.timestep, is_fixed ? 0 : when);
    scene.Add(trajectory(0).PlaceAt(when) - velocity * when - fall + random.Vector(2.5), velocity,
              is_fixed ? 0 : 1);
    const omissions::Trajectory a = trajectory(0), b = trajectory(1);
    const omissions::Approach approach = omissions::ApproachOf(a, b, horizon.end);
    constexpr int kLooks = 20000;
    double least = 1e300, first = 1e300;
    for (int i = 0; i <= kLooks; ++i) {
      const double time = horizon.end * i / kLooks;
      const double gap = (a.PlaceAt(time) - b.PlaceAt(time)).norm() - kPairTouch;
      least = std::min(least, gap);
      if (gap <= 0) first = std::min(first, time);
    }
    const double step = horizon.end / kLooks;
    const double fastest =
        a.FastestUntil(horizon.end) + b.FastestUntil(horizon.end) + g.norm() * horizon.timestep;
    if (approach.meets) {
      ++meetings;
      if (least <= 0) {
        EXPECT_LE(approach.time, first);
        EXPECT_GT(approach.time, first - step - 1e-9);
      } else {
        EXPECT_LT(least, step * fastest);  // between two samples
      }
    } else {
      ++escapes;
      EXPECT_GT(least, 0);
      EXPECT_LE(approach.gap, least);
      EXPECT_GT(approach.gap, least - step * fastest - 1e-9);
    }
  }
  EXPECT_GT(meetings, Cases(100));
  EXPECT_GT(escapes, Cases(100));
}

TEST(Trajectory, RestCountsLooksThatFindItSlow) {
  Random random(5);
  int rests = 0;
  for (int round = 0; round < Cases(2000); ++round) {
    HandMade scene;
    scene.Set("cycles", std::uint64_t{400});
    scene.Add(Vector3d::Zero(), random.Vector(std::pow(10, random(-1, 0.5))));
    const Vector3d g = random.Vector(std::pow(10, random(-3, 1)));
    const omissions::Horizon horizon = omissions::HorizonOf(scene.scene);
    double slow = 0, longest = 0;
    Vector3d v = scene.state.objects[0].linear_velocity;
    for (double step = 0; step < horizon.steps; ++step) {
      v += g * horizon.timestep;
      slow = v.norm() < omissions::kSlowSpeed ? slow + horizon.timestep : 0;
      longest = std::max(longest, slow);
    }
    const double rest = omissions::LongestRest(scene.state.objects[0], g, horizon);
    EXPECT_GE(rest, longest - 1e-9);
    EXPECT_LE(rest, longest + 2 * horizon.timestep + 1e-9);
    rests += longest > 0 && longest < horizon.steps * horizon.timestep;
  }
  EXPECT_GT(rests, Cases(300));
}

TEST(Trajectory, SpinKeepsAwakeWhereItStays) {
  HandMade scene;
  scene.Add(Vector3d::Zero());
  ObjectState& object = scene.state.objects[0];
  const omissions::Horizon horizon = omissions::HorizonOf(scene.scene);
  const auto rest = [&] { return omissions::LongestRest(object, Vector3d::Zero(), horizon); };
  EXPECT_EQ(rest(), horizon.end);
  object.angular_velocity = Vector3d(0.6, 0, 0.81);  // 1.008
  EXPECT_EQ(rest(), 0);
  object.angular_velocity = Vector3d(0.6, 0, 0.79);  // 0.992
  EXPECT_EQ(rest(), horizon.end);
  object.angular_velocity = Vector3d(0, 0, 5);
  EXPECT_EQ(rest(), 0);
  object.numbers["angular_damping"] = 0.1;
  EXPECT_EQ(rest(), horizon.end);
  object.numbers["angular_damping"] = 0;
  object.solid.sides.y() = 1.5;
  EXPECT_EQ(rest(), horizon.end);  // its spin changes
  object.solid = {objects::Shape::kCuboid, Vector3d::Ones()};
  EXPECT_EQ(rest(), 0);
}

}  // namespace
}  // namespace cdb::tests
