// Thousands of small random scenes, each moved cycle by cycle by an adversary: bodies within
// touching distance may be flung in any direction that energy (and, in the air, momentum) permits.
// The reachability analysis must have permitted every outcome.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "runtime/omissions/omissions.h"
#include "tests/runtime/omissions/hand_made_scene.h"
#include "tests/runtime/omissions/random.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using layouts::ObjectState;

struct Touching {
  double radius, threshold;
  Vector3d extent;  ///< half of its box; constant, because fixed bodies do not rotate
};

/// Computed from the documented facts, not by the code under test.
Touching TouchingOf(const ObjectState& object) {
  const double disc = object.solid.HalfExtents().norm();
  const double radius = object.solid.IsBall() ? object.solid.sides.x() / 2 : disc;
  return {radius, 0.02 * disc,
          object.IsFixed() ? object.solid.HalfExtents() : Vector3d::Constant(radius)};
}

HandMade RandomScene(Random& random) {
  HandMade scene;
  const double side = random(30, 150);
  scene.Set("world.side", side);
  scene.Set("timestep", random(0.005, 0.05));
  scene.Set("cycles", static_cast<std::uint64_t>(random(5, 120)));
  scene.Set("precision", Word(random.Chance(0.5) ? "single" : "double"));
  scene.Set("sleeping", random.Chance(0.5));
  const char* const walls[] = {"all", "all", "all", "floor", "none"};
  scene.Set("world.walls", Word(walls[random.engine() % 5]));
  if (random.Chance(0.7)) scene.state.acceleration = random.Vector(random.Chance(0.5) ? 10 : 1);
  const bool is_damped = random.Chance(0.2), is_slow = random.Chance(0.2);
  const double seconds =
      scene.scene.world.Real("timestep") * static_cast<double>(scene.scene.world.Count("cycles"));
  const double speed = is_slow ? 0.6 : random(0, 0.8) * side / seconds;
  const double size = random(0.2, 2);
  const auto count = static_cast<int>(random(1, 10));
  for (int i = 0; i < count; ++i) {
    const Vector3d velocity = random.Vector(speed);
    Vector3d place = random.Vector(side / 2 - 2 * size);
    if (i > 0 && random.Chance(0.6)) {
      // A position near an earlier object at some time, if it is in the cube.
      const ObjectState& goal = scene.state.objects[random.engine() % scene.state.objects.size()];
      const Vector3d start = goal.pose.position +
                             (goal.linear_velocity - velocity) * random(0, 0.8) * seconds +
                             random.Vector(size);
      const bool is_inside = start.cwiseAbs().maxCoeff() < side / 2 - 2 * size;
      if (is_inside && (start - goal.pose.position).norm() > 4 * size) place = start;
    }
    scene.Add(place, velocity, random.Chance(0.15) ? 0 : std::pow(10, random(-1, 1)));
    if (scene.state.objects.back().IsFixed()) scene.state.objects.back().linear_velocity.setZero();
    ObjectState& object = scene.state.objects.back();
    object.solid.sides.setConstant(random(0.5, 1) * size);
    if (random.Chance(0.3)) {
      object.solid = {objects::Shape::kCuboid, size * Vector3d(0.5, 1, 0.7)};
      object.angular_velocity = random.Vector(5);
      object.angular_velocity.x() += 0.01;  // rotated consistently with its radius
    }
    if (is_damped && random.Chance(0.5)) object.numbers["linear_damping"] = random(0.05, 0.9);
  }
  return scene;
}

/// A body with numbers of type T, as in Bullet.
template <typename T>
class Adversary {
  using Vector = Eigen::Matrix<T, 3, 1>;

 public:
  Adversary(const HandMade& scene, Random& random)
      : scene_(scene),
        random_(random),
        dt_(static_cast<T>(scene.scene.world.Real("timestep"))),
        half_(scene.scene.world.Real("world.side") / 2),
        standing_(omissions::StandingWalls(scene.scene)),
        sleeps_(scene.scene.world.On("sleeping")),
        cluster_(scene.state.objects.size()) {
    std::iota(cluster_.begin(), cluster_.end(), std::size_t{0});
    for (const ObjectState& it : scene.state.objects) {
      const Vector3d spin = it.angular_velocity;
      Body body;
      body.x = it.pose.position.cast<T>();
      body.v = it.linear_velocity.cast<T>();
      body.touching = TouchingOf(it);
      body.mass = it.mass;
      body.kept = static_cast<T>(std::pow(1 - it.numbers["linear_damping"], double{dt_}));
      body.spin_energy = it.mass * spin.cwiseAbs2().dot(it.solid.InertiaPerMass()) / 2;
      body.may_sleep = random.Chance(0.8);
      bodies_.push_back(body);
    }
  }

  /// Bits of the walls that each body has touched.
  std::vector<std::uint8_t> walls() const {
    std::vector<std::uint8_t> walls;
    for (const Body& body : bodies_) walls.push_back(body.walls);
    return walls;
  }
  bool HasTouched() const { return has_touched_; }
  std::size_t LargestCluster() const {
    std::size_t largest = 1;
    for (std::size_t i = 0; i < cluster_.size(); ++i)
      largest = std::max(largest, static_cast<std::size_t>(std::ranges::count(cluster_, i)));
    return largest;
  }

  void Run() {
    for (std::uint64_t cycle = 0; cycle < scene_.scene.world.Count("cycles"); ++cycle) {
      for (Body& body : bodies_)
        if (body.mass > 0) body.v *= body.kept;
      const std::vector<Body> before = bodies_;
      for (std::size_t i = 0; i < bodies_.size(); ++i) {
        TouchWalls(i);
        for (std::size_t j = 0; j < i; ++j) TouchPair(i, j, before);
      }
      for (Body& body : bodies_) Move(body);
    }
  }

 private:
  struct Body {
    Vector x, v;
    Touching touching{};
    double mass = 0;
    T kept = 1;
    double spin_energy = 0;
    double slow_for = 0;
    bool may_sleep = false, is_asleep = false;
    std::uint8_t walls = 0;
  };

  void Wake(Body& body) {
    body.is_asleep = false;
    body.slow_for = 0;
  }

  void TouchWalls(std::size_t i) {
    Body& body = bodies_[i];
    if (body.mass == 0) return;
    for (int wall = 0; wall < 6; ++wall) {
      if ((standing_ >> wall & 1) == 0) continue;
      const int axis = wall / 2;
      const double sign = wall % 2 == 0 ? -1 : 1;
      const double depth = sign * static_cast<double>(body.x[axis]) + body.touching.radius - half_;
      if (depth >= body.touching.threshold * -1) {
        body.walls |= static_cast<std::uint8_t>(1 << wall);
        has_touched_ = true;
        Wake(body);
        Fling(body);
      }
      // The wall holds: a body that is in it goes no deeper.
      if (depth >= 0 && sign * static_cast<double>(body.v[axis]) > 0) body.v[axis] *= -1;
    }
  }

  /// A target: anywhere, straight to a wall, or another object.
  Vector3d Aim(const Body& body) {
    if (random_.Chance(0.3)) return random_.Direction();
    if (random_.Chance(0.6))
      return (random_.Chance(0.5) ? 1 : -1) * Vector3d::Unit(random_.engine() % 3);
    const Body& goal = bodies_[random_.engine() % bodies_.size()];
    const Vector3d there = (goal.x - body.x).template cast<double>();
    return there.isZero(0) ? random_.Direction() : Vector3d(there.normalized());
  }

  /// Flings a body in any direction; the energy of its spin becomes speed.
  void Fling(Body& body) {
    if (random_.Chance(0.3)) return;
    const double energy =
        body.mass * body.v.template cast<double>().squaredNorm() / 2 + body.spin_energy;
    body.spin_energy = 0;
    body.v = (std::sqrt(2 * energy / body.mass) * Aim(body)).template cast<T>();
  }

  void TouchPair(std::size_t i, std::size_t j, const std::vector<Body>& before) {
    Body &a = bodies_[i], &b = bodies_[j];
    if (a.mass == 0 && b.mass == 0) return;
    const Vector3d apart = (before[i].x - before[j].x).template cast<double>();
    const double threshold = std::min(a.touching.threshold, b.touching.threshold);
    if (apart.norm() > a.touching.radius + b.touching.radius + threshold) return;
    const Vector3d between = apart.cwiseAbs() - a.touching.extent - b.touching.extent;
    if (between.maxCoeff() > threshold) return;
    has_touched_ = true;
    for (Body* body : {&a, &b}) Wake(*body);
    if (a.mass == 0) return Fling(b);
    if (b.mass == 0) return Fling(a);
    const std::size_t old = cluster_[i];
    for (std::size_t& cluster : cluster_)
      if (cluster == old) cluster = cluster_[j];
    // In the centre-of-momentum frame: any direction and, with the energy of the spins, the full
    // speed.
    const Vector3d va = a.v.template cast<double>(), vb = b.v.template cast<double>();
    const Vector3d centre = (a.mass * va + b.mass * vb) / (a.mass + b.mass);
    const double reduced = a.mass * b.mass / (a.mass + b.mass);
    const double energy = reduced * (va - vb).squaredNorm() / 2 + a.spin_energy + b.spin_energy;
    a.spin_energy = b.spin_energy = 0;
    const double kept = random_.Chance(0.3) ? random_(0, 1) : 1;
    const Vector3d flung = std::sqrt(2 * kept * energy / reduced) * Aim(a);
    a.v = (centre + b.mass / (a.mass + b.mass) * flung).template cast<T>();
    b.v = (centre - a.mass / (a.mass + b.mass) * flung).template cast<T>();
  }

  void Move(Body& body) {
    if (body.mass == 0 || body.is_asleep) return;
    body.v += scene_.state.acceleration.template cast<T>() * dt_;
    body.x += body.v * dt_;
    body.slow_for = body.v.norm() < T(0.8) ? body.slow_for + double{dt_} : 0;
    // The spin of a cuboid may be slow or not; a ball has none here.
    if (sleeps_ && body.may_sleep && body.slow_for > 2) {
      body.is_asleep = true;
      body.v.setZero();
      body.spin_energy = 0;
    } else if (body.is_asleep) {
      Wake(body);
    }
  }

  const HandMade& scene_;
  Random& random_;
  const T dt_;
  const double half_;
  const std::uint8_t standing_;
  const bool sleeps_;
  std::vector<Body> bodies_;
  std::vector<std::size_t> cluster_;
  bool has_touched_ = false;
};

struct Tally {
  int nothing = 0, something = 0, touched = 0, by_clusters = 0, left_out = 0, clusters = 0;
};

template <typename T>
void Challenge(const HandMade& scene, const omissions::Reachability& reachability, Random& random,
               Tally& tally) {
  Adversary<T> adversary(scene, random);
  adversary.Run();
  const std::vector<std::uint8_t> walls = adversary.walls();
  for (std::size_t i = 0; i < walls.size(); ++i)
    ASSERT_EQ(walls[i] & ~reachability.walls[i], 0)
        << "object " << i + 1 << " of " << walls.size() << "; " << reachability.closest;
  ASSERT_FALSE(reachability.nothing_touches && adversary.HasTouched()) << reachability.closest;
  ASSERT_LE(adversary.LargestCluster(), reachability.largest_cluster);
  tally.touched += adversary.HasTouched();
  tally.clusters += adversary.LargestCluster() > 1;
  if (!adversary.HasTouched()) return;
  // Counts the bodies that touched a wall only because of others.
  HandMade alone = scene;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    if (walls[i] == 0) continue;
    alone.state.objects = {scene.state.objects[i]};
    tally.by_clusters += (walls[i] & ~alone.Make().walls[0]) != 0;
  }
}

TEST(OmissionsProperty, NothingThatCanHappenIsLeftOut) {
  Random random(20260101);
  Tally tally;
  for (int round = 0; round < Cases(5000); ++round) {
    const HandMade scene = RandomScene(random);
    const omissions::Reachability reachability = scene.Make();
    SCOPED_TRACE(testing::Message() << "round " << round);
    const auto moving = static_cast<std::size_t>(
        std::ranges::count_if(scene.state.objects, [](const auto& it) { return !it.IsFixed(); }));
    const std::uint8_t standing = omissions::StandingWalls(scene.scene);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < reachability.walls.size(); ++i) {
      ASSERT_EQ(reachability.walls[i] & ~standing, 0);
      ASSERT_TRUE(!scene.state.objects[i].IsFixed() || reachability.walls[i] == 0);
      kept += static_cast<std::size_t>(std::popcount(reachability.walls[i]));
    }
    ASSERT_LE(reachability.largest_cluster, std::max<std::size_t>(moving, 1));
    ASSERT_FALSE(reachability.closest.empty());
    ASSERT_TRUE(!reachability.nothing_touches || kept == 0);
    ++(reachability.nothing_touches ? tally.nothing : tally.something);
    tally.left_out += !reachability.nothing_touches && standing != 0 &&
                      kept < moving * static_cast<std::size_t>(std::popcount(standing));
    for (int game = 0; game < 5; ++game) {
      if (scene.scene.world.WordOr("precision") == "single") {
        Challenge<float>(scene, reachability, random, tally);
      } else {
        Challenge<double>(scene, reachability, random, tally);
      }
      if (HasFatalFailure()) return;
    }
  }
  // Each outcome is common, so that each check could have failed.
  EXPECT_GT(tally.nothing, Cases(1000));
  EXPECT_GT(tally.something, Cases(1500));
  EXPECT_GT(tally.left_out, Cases(1000));
  EXPECT_GT(tally.touched, Cases(8000));
  EXPECT_GT(tally.clusters, Cases(2500));
  EXPECT_GT(tally.by_clusters, Cases(500));
  RecordProperty("nothing", tally.nothing);
  RecordProperty("something", tally.something);
  RecordProperty("left_out", tally.left_out);
  RecordProperty("touched", tally.touched);
  RecordProperty("clusters", tally.clusters);
  RecordProperty("by_clusters", tally.by_clusters);
}

}  // namespace
}  // namespace cdb::tests
