// Scenes in which objects pass through one another although neither's centre does, and look-alikes.
#include <cmath>
#include <numbers>

#include "tests/runtime/engine/known_scene_builder.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// Moves along x, and is half a step before `x` at the end of a step.
KnownBody Flying(std::string_view type, const Vector3d& sides, double speed, const Vector3d& at) {
  return {.type = type,
          .sides = sides,
          .at = at - Vector3d(10.5 * speed / kKnownHz, 0, 0),
          .velocity = {speed, 0, 0}};
}
KnownBody Fixed(std::string_view type, const Vector3d& sides, const Vector3d& at = {0, 0, 0}) {
  return {.type = type, .sides = sides, .at = at, .mass = 0};
}
KnownBody Kinematic(KnownBody body) {
  body.is_kinematic = true;
  return body;
}

/// In half a turn of the blades below; then their poses repeat.
constexpr double kBladeSteps = 6;
constexpr double kBladeSpin = std::numbers::pi / kBladeSteps * kKnownHz;
/// `radius` from the middle of a blade, which has the direction at the given step.
Vector3d AtStep(double step, double radius) {
  const double angle = step * std::numbers::pi / kBladeSteps;
  return radius * Vector3d(std::cos(angle), 0, -std::sin(angle));
}
/// A flat bar that turns about the vertical; 1 m above the floor of a cube of 20 m.
KnownBody Blade(const Vector3d& sides = {10, 0.4, 0.1}) {
  return {.type = "cuboid", .sides = sides, .at = {0, -9.5, 0}, .spin = {0, kBladeSpin, 0}};
}
KnownBuilder UnderBlade(double step, double radius, const KnownBody& blade) {
  KnownBuilder builder(20, "floor", 60);
  for (const std::string_view type : {"cuboid", "cylinder", "cone"}) {
    KnownBody body = Standing(type, {0.4, 1, 0.4}, 0, 1);
    const Vector3d place = AtStep(step, radius);
    body.at.x() = place.x();
    body.at.z() = place.z();
    builder.Add(body);
    step += 2;
  }
  return builder.Add(blade);
}

/// Its tube is 1 m thick, its hole 2 m wide; lies flat.
constexpr double kTubeMiddle = 1.5;
KnownBody Ring() { return Fixed("torus", {4, 1, 4}); }
/// Falls without gravity.
KnownBody Arrow(std::string_view type, double x, double length) {
  const double speed = 150;
  return {.type = type,
          .sides = {0.05, length, 0.05},
          .at = {x, 10.5 * speed / kKnownHz, 0},
          .velocity = {0, -speed, 0}};
}

}  // namespace

void KnownCatalogue::PassingOffCentre() {
  const auto weightless = [] { return KnownBuilder(200).Weightless(); };
  Begin(Fault::kPassing, false, "plate through a plate", "2.5 m a step; they overlap off centre");
  for (const double aside : {0.0, 4.0, 6.0, 9.0}) {
    const KnownBody plate = Flying("cuboid", {0.1, 10, 10}, 150, {0, aside, aside / 3});
    KnownBody other = Fixed("cuboid", plate.sides);
    Add(fmt::format("{} m aside, fixed", aside), weightless().Add(plate).Add(other));
    other.mass = 1;
    Add(fmt::format("{} m aside, free", aside), weightless().Add(plate).Add(other));
  }
  // At 15,360 Hz it loses a quarter of its speed.
  Begin(Fault::kPassing, false, "plate along a plate's edge", "5 mm of their faces meet");
  const KnownBody edge = Flying("cuboid", {0.1, 10, 10}, 150, {0, 9.995, 3});
  Add("fixed", weightless().Add(edge).Add(Fixed("cuboid", edge.sides)));
  Begin(Fault::kPassing, false, "tilted plate through a plate", "as for parallel ones");
  for (const double turn : {0.2, 0.5}) {
    KnownBody plate = Flying("cuboid", {0.1, 10, 10}, 300, {0, 6, 0});
    plate.turn.z() = turn;
    Add(fmt::format("{} rad", turn), weightless().Add(plate).Add(Fixed("cuboid", {0.1, 10, 10})));
  }
  Begin(Fault::kPassing, false, "rod through a pole", "they cross where neither has its middle");
  for (const std::string_view type : {"cuboid", "cylinder", "capsule"}) {
    KnownBody rod = Flying(type, {0.1, 10, 0.1}, 60, {0, 3, 4});
    rod.turn.x() = std::numbers::pi / 2;
    Add(std::string(type), weightless().Add(rod).Add(Fixed(type, rod.sides)));
    KnownBody slow = Flying(type, rod.sides, 30, {0, 3, 4});
    slow.turn = rod.turn;
    Add(fmt::format("{}, slow", type), weightless().Add(slow).Add(Fixed(type, rod.sides)));
  }
  Begin(Fault::kPassing, false, "plate pushed out at the back",
        "the step ends behind the middle of the plate, where the way out is the back");
  for (const double aside : {0.0, 2.5}) {
    KnownBody plate = Flying("cuboid", {0.1, 4, 4}, 12, {0.13, aside, 0});
    Add(fmt::format("{} m aside", aside),
        weightless().Add(plate).Add(Fixed("cuboid", plate.sides)));
  }
  Begin(Fault::kPassing, false, "blade through standing objects",
        "no step ends within reach of them");
  for (const double radius : {2.5, 4.0})
    Add(fmt::format("kinematic, {} m", radius), UnderBlade(0.5, radius, Kinematic(Blade())));
  Begin(Fault::kPassing, false, "free blade through a box", "as for a kinematic one");
  for (const double radius : {2.5, 4.0}) {
    KnownBody box{.type = "cuboid", .sides = Vector3d::Constant(0.4), .at = AtStep(0.5, radius)};
    KnownBody blade = Blade();
    blade.at.y() = 0.2;
    Add(fmt::format("{} m", radius), weightless().Add(box).Add(blade));
  }
  Begin(Fault::kPassing, false, "wall moves over standing boxes", "as for a free one");
  for (const double z : {0.0, 4.0}) {
    KnownBody wall = Kinematic(Flying("cuboid", {0.2, 2, 10}, 150, {0, -8.5, z}));
    Add(fmt::format("{} m aside", z),
        KnownBuilder(20, "floor", 15).Add(Standing("cuboid", Vector3d::Ones(), 0, 1)).Add(wall));
  }
  Begin(Fault::kPassing, false, "arrow through a ring's tube", "2.5 m a step");
  for (const std::string_view type : {"cuboid", "cylinder"})
    for (const double x : {kTubeMiddle, kTubeMiddle - 0.3, -kTubeMiddle})
      Add(fmt::format("{}, {} m", type, x), weightless().Add(Arrow(type, x, 1)).Add(Ring()));
}

void KnownCatalogue::NotPassingOffCentre() {
  const auto weightless = [] { return KnownBuilder(200).Weightless(); };
  Begin(Fault::kPassing, true, "arrow through a ring's hole", "nothing is there");
  for (const std::string_view type : {"cuboid", "cylinder"})
    for (const double x : {0.0, 0.5, 0.9})
      Add(fmt::format("{}, {} m", type, x), weightless().Add(Arrow(type, x, 1)).Add(Ring()));
  Begin(Fault::kPassing, true, "plate past a plate", "its edge misses");
  for (const double gap : {0.005, 0.1}) {
    const KnownBody plate = Flying("cuboid", {0.1, 10, 10}, 150, {0, 10 + gap, 3});
    Add(fmt::format("{} m", gap), weightless().Add(plate).Add(Fixed("cuboid", plate.sides)));
  }
  Begin(Fault::kPassing, true, "rod past a pole's end", "it misses, or grazes by 5 mm of 100");
  for (const double gap : {-0.005, 0.005, 0.1}) {
    KnownBody rod = Flying("cylinder", {0.1, 10, 0.1}, 60, {0, 5.05 + gap, 4});
    rod.turn.x() = std::numbers::pi / 2;
    Add(fmt::format("{} m", gap), weightless().Add(rod).Add(Fixed("cylinder", rod.sides)));
  }
  Begin(Fault::kPassing, true, "plates slide past each other", "they move along their faces");
  for (const double speed : {10.0, 150.0}) {
    const KnownBody plate = Flying("cuboid", {10, 0.1, 10}, speed, {0, 0.15, 2});
    Add(fmt::format("{} m/s", speed), weightless().Add(plate).Add(Fixed("cuboid", plate.sides)));
  }
  Begin(Fault::kPassing, true, "box at a thick block",
        "a step that ends in the block ends in front of its middle");
  for (const double speed : {6.0, 30.0, 60.0}) {
    const KnownBody box = Flying("cuboid", Vector3d::Ones(), speed, {0, 1, 1});
    Add(fmt::format("{} m/s", speed),
        weightless().Add(box).Add(Fixed("cuboid", {5, 8, 8}, {3, 0, 0})));
  }
  Begin(Fault::kPassing, true, "slow plate at a plate", "a step is a third of their thickness");
  for (const double aside : {0.0, 2.5}) {
    const KnownBody plate = Flying("cuboid", {0.3, 4, 4}, 6, {-0.3, aside, 0});
    Add(fmt::format("{} m aside", aside),
        weightless().Add(plate).Add(Fixed("cuboid", plate.sides)));
  }
  Begin(Fault::kPassing, true, "blade beside standing objects", "above them or out of reach");
  {
    KnownBody above = Kinematic(Blade());
    above.at.y() = -8.7;
    Add("above", UnderBlade(0.5, 3, above));
    Add("out of reach", UnderBlade(0.5, 5.4, Kinematic(Blade())));
  }
  Begin(Fault::kPassing, true, "slow wall pushes a box",
        "it moves by a hundredth of the box a step");
  for (const double z : {0.0, 4.0}) {
    KnownBody wall = Kinematic(Flying("cuboid", {0.2, 2, 10}, 0.6, {-0.8, -8.5, z}));
    Add(fmt::format("{} m aside", z),
        KnownBuilder(20, "floor", 120).Add(Standing("cuboid", Vector3d::Ones(), 0, 1)).Add(wall));
  }
  Begin(Fault::kPassing, true, "ball at a spinning box", "it is thrown back from any side");
  // At other spins it meets an edge of the box, which Bullet rounds by its margin: the impact is
  // off.
  for (const double spin : {5.0}) {
    KnownBody box{.type = "cuboid", .sides = Vector3d::Ones(), .spin = {0, 0, spin}};
    KnownBody ball = Flying("sphere", Vector3d::Constant(0.5), 3, {-0.9, 0.2, 0});
    Add(fmt::format("{} rad/s", spin), weightless().Add(box).Add(ball));
  }
}

}  // namespace cdb::tests
