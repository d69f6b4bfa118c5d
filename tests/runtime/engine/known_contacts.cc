// Scenes in which objects pass through one another or are crushed.
#include <cmath>

#include "tests/runtime/engine/known_scene_builder.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// Bullet loses the contacts of a greater mass; kg (sqrt(3) / epsilon).
constexpr double kLosesContacts = 1.75 / kEpsilon;

/// A ball of 0.2 m that moves along x towards a plate of 0.1 m, and is half a step before its
/// middle at the end of a step.
KnownBody BallAtPlate(double speed) {
  return {.sides = Vector3d::Constant(0.2),
          .at = {-10.5 * speed / kKnownHz, 0, 0},
          .velocity = {speed, 0, 0}};
}
KnownBody Plate(double thickness = 0.1) {
  return {.type = "cuboid", .sides = {thickness, 4, 4}, .mass = 0};
}

}  // namespace

void KnownCatalogue::Passing() {
  constexpr double kSpeeds[] = {50, 100, 200, 400};
  Begin(Fault::kPassing, false, "ball through a fixed plate",
        "no step ends within reach of the plate");
  for (const double speed : kSpeeds)
    Add(fmt::format("{} m/s", speed),
        KnownBuilder(200).Weightless().Add(BallAtPlate(speed)).Add(Plate()));
  Begin(Fault::kPassing, false, "ball through a plate, and falling",
        "as without gravity: 10 steps of falling are 0.14 m");
  for (const double speed : kSpeeds)
    Add(fmt::format("{} m/s", speed), KnownBuilder(500).Add(BallAtPlate(speed)).Add(Plate()));
  Begin(Fault::kPassing, false, "plate over a resting ball", "no step ends within reach");
  for (const double speed : {50.0, 150.0, 400.0}) {
    KnownBody plate = Plate(), ball = BallAtPlate(speed);
    plate.mass = 1;
    plate.velocity = -ball.velocity;
    plate.at = -ball.at;
    ball.at = ball.velocity = Vector3d::Zero();
    Add(fmt::format("{} m/s", speed), KnownBuilder(200).Weightless().Add(ball).Add(plate));
  }
  Begin(Fault::kPassing, false, "two balls head on",
        "they are two radii apart before and after the step in which they meet");
  for (const double speed : {60.0, 120.0, 300.0}) {
    KnownBody left = BallAtPlate(speed), right = left;
    right.at.x() *= -1;
    right.velocity *= -1;
    Add(fmt::format("{} m/s each", speed), KnownBuilder(200).Weightless().Add(left).Add(right));
  }
  Begin(Fault::kPassing, false, "ball pushed out at the back",
        "the step ends behind the middle of the plate, where the way out is the back");
  for (const double speed : {30.0, 60.0, 90.0}) {
    KnownBody ball = BallAtPlate(speed);
    ball.at.x() = -10 * speed / kKnownHz + 0.03;
    Add(fmt::format("{} m/s", speed), KnownBuilder(200).Weightless().Add(ball).Add(Plate()));
  }
  Begin(Fault::kPassing, false, "ball over the end of a thin rod",
        "the rod runs through the ball, but through neither's centre");
  for (const double speed : {100.0, 200.0}) {
    KnownBody ball = BallAtPlate(speed);
    ball.sides = Vector3d::Constant(1);
    ball.at.y() = 0.2;
    const KnownBody rod{.type = "cuboid", .sides = {0.05, 0.05, 10}, .at = {0, 0, 3}, .mass = 0};
    Add(fmt::format("{} m/s", speed), KnownBuilder(200).Weightless().Add(ball).Add(rod));
  }
  Begin(Fault::kPassing, false, "two plates and a ball between them",
        "two fly towards each other and leave it behind");
  for (const double speed : {60.0, 120.0}) {
    KnownBody left = Plate(), right = Plate(), ball;
    left.mass = right.mass = 1;
    left.at.x() = -10.5 * speed / kKnownHz;
    right.at.x() = 12.5 * speed / kKnownHz;
    left.velocity.x() = speed;
    right.velocity.x() = -speed;
    ball.sides = Vector3d::Constant(0.2);
    Add(fmt::format("{} m/s", speed),
        KnownBuilder(200).Weightless().Add(ball).Add(left).Add(right));
  }
  Begin(Fault::kPassing, false, "spinning rod over a ball", "its tip moves by ten balls in a step");
  for (const double turn : {0.3, 0.4, 0.5}) {
    KnownBody rod{.type = "cuboid", .sides = {10, 0.1, 0.1}, .spin = {0, 0, turn * kKnownHz}};
    KnownBody ball{.sides = Vector3d::Constant(0.1)};
    ball.at = 4.5 * Vector3d(std::cos(4.5 * turn), std::sin(4.5 * turn), 0);
    Add(fmt::format("{} rad", turn), KnownBuilder(200).Weightless().Add(ball).Add(rod));
  }
}

void KnownCatalogue::NotPassing() {
  Begin(Fault::kPassing, true, "ball beside a plate", "the plate ends a radius before its path");
  for (const double speed : {50.0, 100.0, 200.0, 400.0}) {
    KnownBody ball = BallAtPlate(speed);
    ball.at.y() = 2.2;
    Add(fmt::format("{} m/s", speed), KnownBuilder(200).Weightless().Add(ball).Add(Plate()));
  }
  Begin(Fault::kPassing, true, "slow ball at a plate", "a step is a third of their depths");
  for (const double phase : {0.0, 0.25, 0.5, 0.75}) {
    KnownBody ball = BallAtPlate(6);
    ball.at.x() += phase * 6 / kKnownHz;
    Add(fmt::format("phase {}", phase), KnownBuilder(200).Weightless().Add(ball).Add(Plate()));
  }
  Begin(Fault::kPassing, true, "ball with ccd", "continuous detection stops it at the plate");
  for (const double speed : {50.0, 100.0, 200.0, 400.0}) {
    KnownBody ball = BallAtPlate(speed);
    ball.ccd = true;
    Add(fmt::format("{} m/s", speed), KnownBuilder(200).Weightless().Add(ball).Add(Plate()));
  }
  Begin(Fault::kPassing, true, "ball and plate fly together", "they do not move to each other");
  for (const double speed : {50.0, 400.0}) {
    KnownBody ball = BallAtPlate(speed), plate = Plate();
    ball.at.x() = -1;
    plate.mass = 1;
    plate.velocity = ball.velocity;
    Add(fmt::format("{} m/s", speed), KnownBuilder(2000).Weightless().Add(ball).Add(plate));
  }
  Begin(Fault::kPassing, true, "two balls that miss", "their paths are three radii apart");
  for (const double speed : {60.0, 300.0}) {
    KnownBody left = BallAtPlate(speed), right = left;
    right.at = {-left.at.x(), 0.3, 0};
    right.velocity *= -1;
    Add(fmt::format("{} m/s each", speed), KnownBuilder(200).Weightless().Add(left).Add(right));
  }
  Begin(Fault::kPassing, true, "ball at a thick block",
        "a step that ends in the block ends in front of its middle");
  for (const double speed : {30.0, 60.0, 120.0}) {
    KnownBody ball = BallAtPlate(speed), block = Plate(5);
    block.at.x() = 2.5;
    Add(fmt::format("{} m/s", speed), KnownBuilder(200).Weightless().Add(ball).Add(block));
  }
  Begin(Fault::kPassing, true, "spinning rod beside a ball", "the ball is out of its reach");
  for (const double turn : {0.3, 0.5}) {
    KnownBody rod{.type = "cuboid", .sides = {10, 0.1, 0.1}, .spin = {0, 0, turn * kKnownHz}};
    KnownBody ball{.sides = Vector3d::Constant(0.1), .at = {5.2, 0, 0}};
    Add(fmt::format("{} rad", turn), KnownBuilder(200).Weightless().Add(ball).Add(rod));
  }
}

void KnownCatalogue::Crushing() {
  const Vector3d one = Vector3d::Ones();
  Begin(Fault::kCrushing, false, "heavy box on a light one",
        "a hundred times what ten iterations carry");
  for (const double ratio : {1e4, 1e5, 1e6})
    Add(fmt::format("{:g}", ratio), KnownBuilder(20, "floor", 240)
                                        .Add(Standing("cuboid", one, 0, 1))
                                        .Add(Standing("cuboid", one, 1, ratio)));
  Begin(Fault::kCrushing, false, "heavy block on a small light object", "as for boxes");
  for (const std::string_view type : {"cuboid", "sphere", "cylinder"})
    for (const double ratio : {1e5, 1e6})
      Add(fmt::format("{} {:g}", type, ratio), KnownBuilder(20, "floor", 240)
                                                   .Add(Standing(type, one / 2, 0, 1))
                                                   .Add(Standing("cuboid", {4, 1, 4}, 0.5, ratio)));
  Begin(Fault::kCrushing, false, "heavy box on a column of light ones", "as for boxes");
  for (const double ratio : {1e4, 1e5, 1e6}) {
    KnownBuilder builder(20, "floor", 240);
    for (int i = 0; i < 4; ++i) builder.Add(Standing("cuboid", one, i, 1));
    Add(fmt::format("{:g}", ratio), builder.Add(Standing("cuboid", one, 4, ratio)));
  }
  Begin(Fault::kCrushing, false, "box with a mass beyond the precision",
        "its contacts with fixed bodies are lost without a word");
  for (const double factor : {10.0, 100.0, 1e4}) {
    KnownBody ground = Standing("cuboid", {4, 4, 4}, 0, 0);
    Add(fmt::format("{:g}", factor), KnownBuilder(20, "none", 120)
                                         .Add(ground)
                                         .Add(Standing("cuboid", one, 4, factor * kLosesContacts)));
  }
  Begin(Fault::kCrushing, false, "heavy ball on a light one in a shaft", "as for boxes");
  for (const double ratio : {1e4, 1e5, 1e6}) {
    KnownBuilder builder(20, "floor", 240);
    builder.Add(Standing("sphere", one, 0, 1)).Add(Standing("sphere", one, 1, ratio));
    for (const double x : {-1.01, 1.01}) {
      KnownBody side = Standing("cuboid", {1, 4, 4}, 0, 0),
                front = Standing("cuboid", {4, 4, 1}, 0, 0);
      side.at.x() = front.at.z() = x;
      front.sides = {1.01, 4, 1};
      builder.Add(side).Add(front);
    }
    Add(fmt::format("{:g}", ratio), builder);
  }
  Begin(Fault::kCrushing, false, "one iteration", "a hundred times what it carries");
  for (const double ratio : {1e3, 1e4, 1e5})
    Add(fmt::format("{:g}", ratio), KnownBuilder(20, "floor", 240)
                                        .World("solver.iterations", std::uint64_t{1})
                                        .Add(Standing("cuboid", one, 0, 1))
                                        .Add(Standing("cuboid", one, 1, ratio)));
}

void KnownCatalogue::NotCrushing() {
  const Vector3d one = Vector3d::Ones();
  Begin(Fault::kCrushing, true, "light box on a heavy one", "holds as far as it is known");
  for (const double ratio : {1.0, 1e2, 1e4, 1e6})
    Add(fmt::format("{:g}", ratio), KnownBuilder(20, "floor", 240)
                                        .Add(Standing("cuboid", one, 0, ratio))
                                        .Add(Standing("cuboid", one, 1, 1)));
  Begin(Fault::kCrushing, true, "slightly heavier box on a light one",
        "less than what ten iterations carry");
  for (const double ratio : {2.0, 5.0, 10.0})
    Add(fmt::format("{:g}", ratio), KnownBuilder(20, "floor", 240)
                                        .Add(Standing("cuboid", one, 0, 1))
                                        .Add(Standing("cuboid", one, 1, ratio)));
  Begin(Fault::kCrushing, true, "ball rolls off a box", "it ends beside and below the box, truly");
  for (const double side : {0.2, 0.5, 1.0, 2.0}) {
    KnownBody ball = Standing("sphere", one / 2, side, 1);
    ball.velocity.x() = 1;
    Add(fmt::format("box {} m", side),
        KnownBuilder(20, "floor", 240).Add(Standing("cuboid", side * one, 0, 10)).Add(ball));
  }
  Begin(Fault::kCrushing, true, "box falls onto another", "an impact that the contact holds");
  // Flat boxes rebound by a fifth of their approach with other contacts.
  for (const double height : {0.5, 1.0, 2.0, 4.0})
    Add(fmt::format("{} m", height), KnownBuilder(20, "floor", 240)
                                         .World("timestep", 1.0 / 240)
                                         .World("contact", Word("faithful"))
                                         .Add(Standing("cuboid", one, 0, 1))
                                         .Add(Standing("cuboid", one, 1 + height, 1)));
  Begin(Fault::kCrushing, true, "box slides off a block", "it falls beside the block, truly");
  for (const double speed : {3.0, 4.0, 5.0}) {
    KnownBody box = Standing("cuboid", one, 2, 1);
    box.velocity.x() = speed;
    box.friction = 0;
    Add(fmt::format("{} m/s", speed),
        KnownBuilder(40, "none", 90).Add(Standing("cuboid", 2 * one, 0, 0)).Add(box));
  }
  Begin(Fault::kCrushing, true, "fast ball hits a wall of boxes", "an impact, soon apart");
  for (const double speed : {5.0, 10.0}) {
    KnownBody ball = Standing("sphere", one, 0.5, 1);
    ball.at.x() = -4;
    ball.velocity.x() = speed;
    // Boxes that slide on a plane turn.
    Add(fmt::format("{} m/s", speed), KnownBuilder(20, "floor", 240)
                                          .World("world.wall_shape", Word("box"))
                                          .Add(ball)
                                          .Add(Standing("cuboid", one, 0, 1))
                                          .Add(Standing("cuboid", one, 1, 1)));
  }
}

}  // namespace cdb::tests
