// Scenes in which energy vanishes, or objects fall asleep without support.
#include <cmath>
#include <numbers>

#include "tests/runtime/engine/known_scene_builder.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

/// A body on the floor of a cube of 20 m, or on a fixed inclined slab of 20 m that descends along
/// x.
KnownBuilder OnSlope(KnownBody body, double slope, bool is_slab) {
  constexpr std::uint64_t kCycles = 240;
  const double angle = std::atan(slope);
  const double below = body.sides.y() / 2;
  if (!is_slab) {
    body.at = {-5, -10 + below + 1e-3, 0};
    KnownBuilder builder(20, "floor", kCycles);
    builder.World("acceleration", Vector3d(9.8 * std::sin(angle), -9.8 * std::cos(angle), 0));
    builder.Add(body);
    return builder;
  }
  const Vector3d normal(std::sin(angle), std::cos(angle), 0);
  body.turn = {0, 0, -angle};
  body.at = (0.5 + below + 1e-3) * normal;
  KnownBuilder builder(100, "none", kCycles);
  builder.Add({.type = "cuboid", .sides = {20, 1, 20}, .turn = {0, 0, -angle}, .mass = 0})
      .Add(body);
  return builder;
}

KnownBuilder KnownChain(std::string_view joint, double hz) {
  KnownBuilder builder(100, "none", static_cast<std::uint64_t>(5 * hz));
  builder.World("timestep", 1 / hz).World("sleeping", false).Add({.type = "cuboid"});
  builder.Group("links.type", Word(joint))
      .Group("quantity", std::uint64_t{4})
      .Group("location", Layout("line", {{"along", Vector3d(1, 0, 0)}}));
  return builder;
}

}  // namespace

void KnownCatalogue::Losing() {
  Begin(Fault::kLosing, false, "elastic ball, Bullet's contacts",
        "speculative contact eats the rebound of a large ball at 60 Hz");
  for (const double drop : {30.0, 50.0, 80.0})
    for (const double friction : {0.0, 0.5})
      Add(fmt::format("drop {} m, friction {}", drop, friction),
          KnownBuilder(500, "floor", 900)
              .World("sleeping", false)
              .Add({.sides = Vector3d::Constant(50),
                    .at = {0, -225 + drop, 0},
                    .friction = friction,
                    .restitution = 1}));
  Begin(Fault::kLosing, false, "elastic ball with ccd",
        "Bullet gives the contacts that it foresees no restitution");
  // Where the sweep foresees the impact, plain Bullet stops the ball: see bullet_facts_test.cc.
  for (const double hz : {30.0, 60.0})
    for (const double friction : {0.0, 0.5})
      Add(fmt::format("{} Hz, friction {}", hz, friction),
          KnownBuilder(30, "floor", static_cast<std::uint64_t>(10 * hz))
              .World("sleeping", false)
              .World("timestep", 1 / hz)
              .World("contact", Word(hz == 60 ? "faithful" : "bullet"))
              .Add({.sides = Vector3d::Constant(0.1),
                    .at = {0, -5, 0},
                    .friction = friction,
                    .restitution = 1})
              .Group("ccd", true));
  Begin(Fault::kLosing, false, "ball that bounces in part, with ccd",
        "the contact that ccd foresees takes all of its energy");
  for (const double restitution : {0.4, 0.5, 0.8})
    Add(fmt::format("restitution {}", restitution),
        KnownBuilder(30, "floor", 300)
            .World("contact", Word("faithful"))
            .Add({.sides = Vector3d::Constant(0.1), .at = {0, -5, 0}, .restitution = restitution})
            .Group("ccd", true));
  Begin(Fault::kLosing, false, "two elastic balls head on, Bullet's contacts",
        "they are pushed out of their overlap, which adds energy");
  for (const double phase : {0.0, 0.3, 0.6}) {
    KnownBody left{.at = {-1.5 - 4.0 / 120 * phase, 0, 0}, .velocity = {3, 0, 0}, .restitution = 1};
    KnownBody right{.at = {1.5, 0, 0}, .velocity = {-1, 0, 0}, .restitution = 1};
    Add(fmt::format("phase {}", phase), KnownBuilder(200, "none", 180)
                                            .Weightless()
                                            .World("timestep", 1.0 / 120)
                                            .Add(left)
                                            .Add(right));
  }
  Begin(Fault::kLosing, false, "elastic ball, Bullet's contacts, small steps",
        "the smaller the step, the more is eaten");
  for (const double size : {1.0, 5.0})
    for (const double hz : {480.0, 960.0})
      Add(fmt::format("{} m, {} Hz", size, hz),
          KnownBuilder(10 * size, "floor", static_cast<std::uint64_t>(8 * hz))
              .World("sleeping", false)
              .World("timestep", 1 / hz)
              .Add({.sides = Vector3d::Constant(size), .restitution = 1}));
  Begin(Fault::kLosing, false, "elastic balls beside each other", "each as one alone");
  for (const int count : {3, 5}) {
    KnownBuilder builder(1000, "floor", 900);
    builder.World("sleeping", false);
    for (int i = 0; i < count; ++i)
      builder.Add({.sides = Vector3d::Constant(50),
                   .at = {100.0 * i - 200, -475.0 + 30 + 5 * i, 0},
                   .restitution = 1});
    Add(fmt::format("{}", count), builder);
  }
  Begin(Fault::kLosing, false, "ball that rolls until it sleeps",
        "nothing resists its rolling, and after two seconds it stops");
  for (const double speed : {0.2, 0.3, 0.4})
    for (const bool is_slab : {false, true}) {
      KnownBody rolling = Standing("sphere", Vector3d::Ones(), 0, 1);
      rolling.velocity.x() = speed;
      rolling.spin.z() = -2 * speed;
      KnownBuilder builder(20, is_slab ? "none" : "floor", 240);
      if (is_slab)
        builder.Add({.type = "cuboid", .sides = {10, 1, 10}, .at = {0, -10.5, 0}, .mass = 0});
      Add(fmt::format("{} m/s, {}", speed, is_slab ? "slab" : "floor"), builder.Add(rolling));
    }
  Begin(Fault::kLosing, false, "chain of four that is let go level",
        "it falls with all its weight into joints that take 40 of 100 in 10 s");
  for (const double hz : {30.0, 60.0})
    for (const std::string_view joint : {"ball", "hinge"})
      Add(fmt::format("{} {} Hz", joint, hz), KnownChain(joint, hz));
  Begin(Fault::kLosing, false, "short pendulum",
        "it turns far in a step, and the joint's correction takes energy in each");
  for (const double size : {0.05, 0.1})
    for (const double hz : {30.0, 60.0})
      Add(fmt::format("{} m, {} Hz", size, hz),
          KnownBuilder(20, "none", static_cast<std::uint64_t>(20 * hz))
              .World("sleeping", false)
              .World("timestep", 1 / hz)
              .Add({.sides = Vector3d::Constant(size), .velocity = {1, 0, 0}})
              .Group("links.type", Word("ball")));
  Begin(Fault::kLosing, false, "chain of five balls that is let go level",
        "it comes to rest, which nothing but the joints can bring about");
  for (const double side : {20.0, 100.0})
    Add(fmt::format("in {} m", side),
        KnownBuilder(side, "none", 1200)
            .World("sleeping", false)
            .Add({.sides = Vector3d::Constant(0.5)})
            .Group("links.type", Word("ball"))
            .Group("quantity", std::uint64_t{5})
            .Group("location", Layout("line", {{"along", Vector3d(1, 0, 0)}})));
  Begin(Fault::kLosing, false, "brick that turns about its middle axis",
        "it tumbles, and each step loses (w dt)^2 of its spin");
  for (const double spin : {5.0, 10.0, 20.0, 40.0})
    for (const double gravity : {0.0, 9.8})
      Add(fmt::format("{} rad/s, g {}", spin, gravity),
          KnownBuilder(5000, "none", 900)
              .World("sleeping", false)
              .World("acceleration", Vector3d(0, -gravity, 0))
              .Add({.type = "cuboid", .sides = {1, 2, 3}, .spin = {0.01, spin, 0.01}}));
  Begin(Fault::kLosing, false, "pendulum with large steps",
        "the joint's correction takes energy in each step");
  for (const double hz : {10.0, 15.0, 20.0})
    for (const std::string_view joint : {"ball", "hinge"})
      Add(fmt::format("{} {} Hz", joint, hz), KnownBuilder(100, "none", 900)
                                                  .World("timestep", 1 / hz)
                                                  .World("sleeping", false)
                                                  .Add({.type = "cuboid", .velocity = {3, 0, 0}})
                                                  .Group("links.type", Word(joint)));
}

void KnownCatalogue::NotLosing() {
  Begin(Fault::kLosing, true, "elastic ball, faithful contacts", "they keep a bounce's energy");
  for (const double drop : {30.0, 50.0, 80.0})
    Add(fmt::format("drop {} m", drop),
        KnownBuilder(500, "floor", 900)
            .World("sleeping", false)
            .World("contact", Word("faithful"))
            .Add({.sides = Vector3d::Constant(50), .at = {0, -225 + drop, 0}, .restitution = 1}));
  Begin(Fault::kLosing, true, "ball that bounces by half", "bounces take the energy");
  for (const double restitution : {0.0, 0.5, 0.9})
    Add(fmt::format("restitution {}", restitution),
        KnownBuilder(50, "floor", 600).Add({.at = {0, -20, 0}, .restitution = restitution}));
  Begin(Fault::kLosing, true, "tumbling box that bounces in part", "bounces take the energy");
  for (const double restitution : {0.2, 0.5, 0.8})
    Add(fmt::format("restitution {}", restitution), KnownBuilder(50, "floor", 600)
                                                        .World("contact", Word("faithful"))
                                                        .Add({.type = "cuboid",
                                                              .sides = {1, 2, 1.5},
                                                              .at = {0, -20, 0},
                                                              .velocity = {3, 0, 1},
                                                              .spin = {1, 2, 3},
                                                              .restitution = restitution}));
  Begin(Fault::kLosing, true, "sliding box", "friction takes the energy");
  for (const double speed : {2.0, 5.0, 10.0}) {
    KnownBody box = Standing("cuboid", {2, 0.5, 2}, 0, 1);
    box.velocity.x() = speed;
    Add(fmt::format("{} m/s", speed), KnownBuilder(20, "floor", 300).Add(box));
  }
  Begin(Fault::kLosing, true, "ball that slides until it rolls", "friction takes two sevenths");
  for (const double speed : {2.0, 5.0, 10.0}) {
    KnownBody ball = Standing("sphere", Vector3d::Ones(), 0, 1);
    ball.velocity.x() = speed;
    Add(fmt::format("{} m/s", speed), KnownBuilder(20, "floor", 600).Add(ball));
  }
  Begin(Fault::kLosing, true, "brick that turns about its outer axes", "a steady turn");
  for (const Vector3d& spin : {Vector3d(5, 0, 0), Vector3d(0, 0, 5), Vector3d(20, 0, 0)})
    Add(fmt::format("{} {} {} rad/s", spin.x(), spin.y(), spin.z()),
        KnownBuilder(5000, "none", 900)
            .World("sleeping", false)
            .Add({.type = "cuboid", .sides = {1, 2, 3}, .spin = spin}));
  Begin(Fault::kLosing, true, "brick that turns slowly about its middle axis",
        "steps times (w dt)^2 is below 0.05");
  for (const double spin : {0.1, 0.3})
    Add(fmt::format("{} rad/s", spin),
        KnownBuilder(5000, "none", 900)
            .World("sleeping", false)
            .Add({.type = "cuboid", .sides = {1, 2, 3}, .spin = {0.01, spin, 0.01}}));
  Begin(Fault::kLosing, true, "pendulum with small steps", "corrections are small");
  for (const std::string_view joint : {"ball", "hinge"})
    Add(fmt::format("{}", joint), KnownBuilder(100, "none", 960)
                                      .World("timestep", 1.0 / 480)
                                      .World("sleeping", false)
                                      .Add({.type = "cuboid", .velocity = {1, 0, 0}})
                                      .Group("links.type", Word(joint)));
  Begin(Fault::kLosing, true, "short pendulum with small steps",
        "its joint takes two sevenths at once, as its ball does not turn yet");
  for (const double size : {0.1, 1.0})
    Add(fmt::format("{} m", size),
        KnownBuilder(20, "none", 960)
            .World("sleeping", false)
            .World("timestep", 1.0 / 4800)
            .Add({.sides = Vector3d::Constant(size), .velocity = {1, 0, 0}})
            .Group("links.type", Word("ball")));
  Begin(Fault::kLosing, true, "chain that hangs at rest", "it gives way a little");
  for (const std::string_view joint : {"ball", "hinge", "fixed"})
    Add(std::string(joint),
        KnownBuilder(100, "none", 300)
            .World("sleeping", false)
            .Add({.type = "cuboid"})
            .Group("links.type", Word(joint))
            .Group("quantity", std::uint64_t{5})
            .Group("location", Layout("line", {{"along", Vector3d(0, -1, 0)}})));
  Begin(Fault::kLosing, true, "chain of four with small steps", "corrections are small");
  for (const std::string_view joint : {"ball", "hinge"})
    Add(fmt::format("{}", joint), KnownChain(joint, 480));
  Begin(Fault::kLosing, true, "rolling ball that may not sleep", "it rolls on");
  for (const double speed : {0.2, 1.0}) {
    KnownBody rolling = Standing("sphere", Vector3d::Ones(), 0, 1);
    rolling.at.x() = -8;
    rolling.velocity.x() = speed;
    rolling.spin.z() = -2 * speed;
    Add(fmt::format("{} m/s", speed),
        KnownBuilder(20, "floor", 600).World("sleeping", false).Add(rolling));
  }
  Begin(Fault::kLosing, true, "damped pendulum", "damping takes the energy");
  for (const double damping : {0.1, 0.5})
    Add(fmt::format("{}", damping), KnownBuilder(100, "none", 600)
                                        .Add({.type = "cuboid", .velocity = {2, 0, 0}})
                                        .Group("links.type", Word("ball"))
                                        .Group("linear_damping", damping)
                                        .Group("angular_damping", damping));
}

void KnownCatalogue::Sleeping() {
  const KnownBody box{.type = "cuboid", .sides = {1, 0.5, 1}}, ball;
  Begin(Fault::kSleeping, false, "box on a slope just too steep",
        "it gains less than 0.4 m/s in a second, so that it is asleep after two");
  for (const double slope : {0.265, 0.275, 0.28})
    for (const bool is_slab : {false, true}) {
      KnownBuilder builder = OnSlope(box, slope, is_slab);
      Add(fmt::format("slope {}, {}", slope, is_slab ? "slab" : "floor"), builder);
    }
  Begin(Fault::kSleeping, false, "box without friction on a slight slope", "as above");
  for (const double slope : {0.01, 0.02, 0.03})
    for (const bool is_slab : {false, true}) {
      KnownBody smooth = box;
      smooth.friction = 0;
      KnownBuilder builder = OnSlope(smooth, slope, is_slab);
      Add(fmt::format("slope {}, {}", slope, is_slab ? "slab" : "floor"), builder);
    }
  Begin(Fault::kSleeping, false, "ball on a slight slope", "it rolls, and is asleep as above");
  for (const double slope : {0.001, 0.0049, 0.015, 0.025, 0.033})
    for (const bool is_slab : {false, true}) {
      KnownBuilder builder = OnSlope(ball, slope, is_slab);
      Add(fmt::format("slope {}, {}", slope, is_slab ? "slab" : "floor"), builder);
    }
  Begin(Fault::kSleeping, false, "ball on a slight slope, after a warm-up", "as without one");
  for (const bool is_slab : {false, true})
    Add(is_slab ? "slab" : "floor",
        OnSlope(ball, 0.025, is_slab).World("warmup", std::uint64_t{150}));
  Begin(Fault::kSleeping, false, "ball that falls slowly",
        "in two seconds it is not faster than 0.8 m/s");
  for (const double gravity : {0.05, 0.1, 0.3})
    Add(fmt::format("g {}", gravity),
        KnownBuilder(100, "floor", 240).World("acceleration", Vector3d(0, -gravity, 0)).Add(ball));
  Begin(Fault::kSleeping, false, "object that drifts without gravity", "it is slow, not at rest");
  for (const double speed : {0.01, 0.5})
    Add(fmt::format("{} m/s", speed), KnownBuilder(100, "none", 240)
                                          .Weightless()
                                          .Add({.at = {0, 0, 0}, .velocity = {speed, 0, 0}}));
  Add("spin",
      KnownBuilder(100, "none", 240).Weightless().Add({.type = "cuboid", .spin = {0, 0.2, 0}}));
  Begin(Fault::kSleeping, false, "lying capsule on a slight slope", "it rolls, as a ball");
  for (const double slope : {0.015, 0.03}) {
    KnownBody capsule{.type = "capsule", .sides = {1, 3, 1}};
    capsule.turn = {std::numbers::pi / 2, 0, 0};
    capsule.at = {0, -10 + 0.5 + 1e-3, 0};
    const double angle = std::atan(slope);
    Add(fmt::format("slope {}", slope),
        KnownBuilder(20, "floor", 240)
            .World("acceleration", Vector3d(9.8 * std::sin(angle), -9.8 * std::cos(angle), 0))
            .Add(capsule));
  }
}

void KnownCatalogue::NotSleeping() {
  const KnownBody box{.type = "cuboid", .sides = {1, 0.5, 1}}, ball;
  Begin(Fault::kSleeping, true, "box on a slope that holds it", "friction 0.25 is more");
  for (const double slope : {0.05, 0.1, 0.2, 0.235})
    for (const bool is_slab : {false, true}) {
      KnownBuilder builder = OnSlope(box, slope, is_slab);
      Add(fmt::format("slope {}, {}", slope, is_slab ? "slab" : "floor"), builder);
    }
  Begin(Fault::kSleeping, true, "box on a steep slope", "it is too fast for sleep");
  for (const double slope : {0.4, 0.5, 0.6}) {
    KnownBuilder builder = OnSlope(box, slope, true);
    // Later, rocking has turned it by 0.1 rad.
    Add(fmt::format("slope {}", slope), builder.World("cycles", std::uint64_t{150}));
  }
  Begin(Fault::kSleeping, true, "ball on a slight slope that may not sleep", "it rolls down");
  for (const double slope : {0.015, 0.03}) {
    KnownBuilder builder = OnSlope(ball, slope, true);
    Add(fmt::format("slope {}", slope), builder.World("sleeping", false));
  }
  Begin(Fault::kSleeping, true, "ball with rolling friction on a slight slope", "which holds it");
  for (const double slope : {0.005, 0.01}) {
    KnownBuilder builder = OnSlope(ball, slope, false);
    Add(fmt::format("slope {}", slope), builder.Group("rolling_friction", 0.5));
  }
  Begin(Fault::kSleeping, true, "object at rest without gravity", "nothing moves it");
  Add("", KnownBuilder(100, "none", 240).Weightless().Add(box));
  Begin(Fault::kSleeping, true, "object at rest on the floor", "the floor bears it");
  for (const std::string_view type : {"sphere", "cuboid", "cylinder", "cone", "capsule"})
    Add(std::string(type),
        KnownBuilder(20, "floor", 300).Add(Standing(type, Vector3d::Ones(), 0.05, 1)));
}

std::vector<KnownScene> KnownScenes() {
  KnownCatalogue catalogue;
  catalogue.Passing();
  catalogue.PassingOffCentre();
  catalogue.NotPassing();
  catalogue.NotPassingOffCentre();
  catalogue.Crushing();
  catalogue.NotCrushing();
  catalogue.Losing();
  catalogue.NotLosing();
  catalogue.Sleeping();
  catalogue.NotSleeping();
  return std::move(catalogue.scenes);
}

}  // namespace cdb::tests
