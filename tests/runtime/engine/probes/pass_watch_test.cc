// Objects that pass through one another, or miss, for which geometry has the answer in closed form:
// drawn cases, without a step of the engine.
#include "runtime/engine/probes/pass_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "library/distributions/stream.h"
#include "tests/runtime/engine/known_scene_builder.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using distributions::Stream;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

/// An object and its motion in each cycle.
struct Mover {
  KnownBody body;
  Vector3d way = Vector3d::Zero();  ///< m
  double turn = 0;                  ///< rad, about y
};

btVector3 ToBullet(const Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

/// The states that the objects are given, watched.
class Watched {
 public:
  explicit Watched(const std::vector<Mover>& movers)
      : movers_(movers),
        engine_(WholeEngine(SceneOf(movers), layouts::MakeInitialState(SceneOf(movers)))),
        watch_(engine_) {}

  probes::PassWatch::Seen Cycle() {
    probes::BodyStates before, now;
    ReadStates(engine_, before);
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      btRigidBody& body = *engine_.objects()[i];
      btTransform pose = body.getWorldTransform();
      pose.setOrigin(pose.getOrigin() + ToBullet(movers_[i].way));
      const btQuaternion turn(btVector3(0, 1, 0), static_cast<btScalar>(movers_[i].turn));
      pose.setRotation(turn * pose.getRotation());
      body.setWorldTransform(pose);
      body.setAngularVelocity({0, static_cast<btScalar>(movers_[i].turn) / engine_.timestep(), 0});
    }
    ReadStates(engine_, now);
    return watch_.After(before, now);
  }

 private:
  static plan::Scene SceneOf(const std::vector<Mover>& movers) {
    KnownBuilder builder(1e5);
    builder.Weightless();
    for (const Mover& mover : movers) builder.Add(mover.body);
    return builder.Done();
  }

  const std::vector<Mover> movers_;
  world::Engine engine_;
  probes::PassWatch watch_;
};

struct Known {
  std::vector<Mover> movers;
  std::optional<bool> passes;  ///< nullopt: too close to tell
};

/// Draws cases, also enlarged and with the roles of the two exchanged.
void Check(const char* name, Known (*draw)(Stream&)) {
  Stream stream(7);
  int passes = 0, misses = 0;
  constexpr int kCases = kAddressSanitizer ? 40 : 200;
  for (int i = 0; i < kCases; ++i) {
    Known known = draw(stream);
    if (!known.passes) continue;
    const double factor = std::pow(10, stream.Uniform(-2, 2));
    for (Mover& mover : known.movers) {
      mover.body.sides *= factor;
      mover.body.at *= factor;
      mover.way *= factor;
    }
    if (stream.Uniform(0, 1) < 0.5) std::ranges::reverse(known.movers);
    const probes::PassWatch::Seen seen = Watched(known.movers).Cycle();
    EXPECT_EQ(seen.passed, *known.passes) << name << " " << i << ", enlarged " << factor;
    EXPECT_EQ(seen.unfollowed, 0) << name << " " << i;
    ++(*known.passes ? passes : misses);
  }
  EXPECT_GT(passes, kCases / 5) << name;
  EXPECT_GT(misses, kCases / 5) << name;
}

/// Balls whose centres come as near as `miss`: at a depth d, the normals at the beginning and at
/// the end have the scalar product 2 (miss / (sum of radii - d))^2 - 1.
Known Balls(Stream& stream) {
  const double a = stream.Uniform(0.2, 1), b = stream.Uniform(0.2, 1), side = 2 * std::min(a, b);
  const double miss = stream.Uniform(0, 1.3) * (a + b), deepest = a + b - miss;
  const double run = stream.Uniform(1.2, 20) * (a + b);
  Known known{{{{.sides = Vector3d::Constant(2 * a), .at = {-run, miss, 0}}, {2 * run, 0, 0}},
               {{.sides = Vector3d::Constant(2 * b)}}},
              {}};
  const auto cosine = [&](double depth) {
    return 2 * std::pow(miss / (a + b - depth * side), 2) - 1;
  };
  if (deepest > 1.1 * side || (deepest > 0.4 * side && cosine(0.3) < -0.15))
    known.passes = true;
  else if (deepest < 0.15 * side || (deepest < 0.9 * side && cosine(0.05) > 0.05))
    known.passes = false;
  return known;
}

/// Boxes along the axes, of any sides: plates, rods and blocks. They move along x; across, they
/// overlap by at least 0.4 of the least side, or graze by at most 0.08 of it, or miss.
Known Boxes(Stream& stream) {
  const auto side = [&] { return std::pow(10, stream.Uniform(-1, 1)); };
  Vector3d a, b;
  for (int axis = 0; axis < 3; ++axis) {
    a[axis] = side();
    b[axis] = side();
  }
  const double least = std::min(a.minCoeff(), b.minCoeff());
  const auto overlap = [&](int axis) {
    return stream.Uniform(0, 1) < 0.3 ? least * stream.Uniform(-0.2, 0.08)
                                      : stream.Uniform(0.4, 1) * std::min(a[axis], b[axis]);
  };
  const double y = overlap(1), z = overlap(2), run = stream.Uniform(0.6, 10) * (a.x() + b.x());
  const bool is_kinematic = stream.Uniform(0, 1) < 0.3;
  return {{{{.type = "cuboid",
             .sides = a,
             .at = {-run, (a.y() + b.y()) / 2 - y, z - (a.z() + b.z()) / 2},
             .is_kinematic = is_kinematic},
            {2 * run, 0, 0}},
           {{.type = "cuboid", .sides = b}}},
          std::min(y, z) > 0.1 * least};
}

/// A cylinder or capsule along y that moves along x across one along z.
Known Rods(Stream& stream) {
  const char* type = stream.Uniform(0, 1) < 0.5 ? "cylinder" : "capsule";
  const double width = stream.Uniform(0.05, 0.5), other = stream.Uniform(0.05, 0.5);
  const double length = stream.Uniform(2, 20), least = std::min(width, other);
  const double along = stream.Uniform(-0.4, 0.4) * length;
  // The end of the rod grazes the side of the pole by at most 0.05 of the thinner, or misses it.
  const bool misses = stream.Uniform(0, 1) < 0.5;
  const double y = misses ? (length + other) / 2 + least * stream.Uniform(-0.05, 0.3)
                          : stream.Uniform(0, 0.35) * length;
  const double run = stream.Uniform(1, 20) * (width + other);
  return {{{{.type = type,
             .sides = {width, length, width},
             .at = {-run, y, along},
             .is_kinematic = stream.Uniform(0, 1) < 0.3},
            {2 * run, 0, 0}},
           {{.type = type, .sides = {other, length, other}, .turn = {kPi / 2, 0, 0}}}},
          !misses};
}

/// A bar along x turns about y beside a ball, which it meets between the angles at which the way
/// of the ball's centre from its middle line is the sum of half its width and the radius.
Known Blades(Stream& stream) {
  const Vector3d bar(stream.Uniform(5, 20), stream.Uniform(0.3, 1), stream.Uniform(0.1, 0.3));
  const double radius = stream.Uniform(0.1, 0.3), least = std::min(bar.z(), 2 * radius);
  const double far = stream.Uniform(0, 1) < 0.7
                         ? stream.Uniform(0.3, 0.9) * bar.x() / 2
                         : bar.x() / 2 + radius + stream.Uniform(0.02, 0.3) * least;
  const bool is_kinematic = stream.Uniform(0, 1) < 0.5;
  const double turn = is_kinematic ? stream.Uniform(0.5, 20) : stream.Uniform(0.5, 2.8);
  const double at = stream.Uniform(0, kPi);
  const double half = std::asin((bar.z() / 2 + radius + 0.02 * least) / far);
  Known known{{{{.type = "cuboid", .sides = bar, .is_kinematic = is_kinematic}, {0, 0, 0}, turn},
               {{.sides = Vector3d::Constant(2 * radius),
                 .at = far * Vector3d(std::cos(at), 0, -std::sin(at))}}},
              {}};
  if (far > bar.x() / 2)
    known.passes = false;
  else if (at > half && at < kPi - half && turn > at + half)
    known.passes = true;
  else if (at > half && at < kPi - half && turn < at - half)
    known.passes = false;
  return known;
}

TEST(PassWatch, AgreesWithClosedForms) {
  Check("balls", Balls);
  Check("boxes", Boxes);
  Check("rods", Rods);
  Check("blades", Blades);
}

KnownBody WatchedPlate(double x) {
  return {.type = "cuboid", .sides = {0.1, 10, 10}, .at = {x, 0, 0}, .mass = 0};
}
Mover ThinBall(double y, const Vector3d& way) {
  return {{.sides = Vector3d::Constant(0.2), .at = {-1, y, 0}}, way};
}

TEST(PassWatch, CountsEachObjectOnce) {
  Watched watched({{WatchedPlate(0)},
                   {WatchedPlate(2)},
                   {WatchedPlate(9)},
                   ThinBall(1, {5, 0, 0}),
                   ThinBall(-1, {5, 0, 0}),
                   ThinBall(20, {5, 0, 0}),
                   ThinBall(2, {0, 0.05, 0})});
  for (int cycle = 0; cycle < 4; ++cycle) EXPECT_EQ(watched.Cycle().passed, 2) << cycle;
}

TEST(PassWatch, SaysWhatItCannotFollow) {
  Mover blade{{.type = "cuboid", .sides = {10, 0.4, 0.1}, .is_kinematic = true}, {0, 0, 0}, 1e8};
  Watched watched({blade, {{.sides = Vector3d::Constant(0.1), .at = {5.052, 0, 0}}}});
  const probes::PassWatch::Seen seen = watched.Cycle();
  EXPECT_EQ(seen.passed, 0);
  EXPECT_EQ(seen.unfollowed, 1);
}

}  // namespace
}  // namespace cdb::tests
