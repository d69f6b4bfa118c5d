// What rolls on fixed ground: rolling_error against the speed of closed forms.
#include "runtime/engine/probes/friction_watch.h"

#include <fmt/format.h>

#include <cmath>

#include "dsl/diagnostics.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

struct RollingRun {
  double velocity;       ///< m/s, along x, at the end
  double spin;           ///< rad/s, about -z
  double rolling_error;  ///< at the end; NaN if nothing rolled
  double largest_error;
  protocol::Verdict verdict;
};

RollingRun RunRolling(const std::string& text) {
  const compiler::Compilation compiled = CompileText(fmt::format(
      "benchmark b {{ precision {}; sleeping off\n{} }}", world::EnginePrecision(), text));
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  const plan::Scene& scene = compiled.plans.at(0).runs.at(0).scene;
  const Recorded run = RunHere(scene);
  EXPECT_TRUE(run.done()) << run.message();
  double largest = 0;
  for (const double error : run.recording.Reals("rolling_error"))
    largest = std::fmax(largest, error);
  return {Velocity(*run.engine).x(),
          -static_cast<double>(run.engine->objects()[0]->getAngularVelocity().z()),
          run.recording.Reals("rolling_error").back(), largest,
          protocol::Judge(scene, run.recording, scene.world.Count("cycles")).verdict};
}

/// For 3 s, with the slope as a component of the acceleration. The object is 1 m wide.
std::string Slope(const std::string& object, double slope, double speed, int hz,
                  const std::string& floor) {
  return fmt::format(
      "timestep 1/{}; cycles {}; acceleration ({}, -10, 0)\n"
      "world {{ side 200; walls floor; wall_friction 1; {} }}\n"
      "objects {{ quantity 1; size 1; friction 1; location at(-50, -99.4999, 0); {}\n"
      "linear_velocity ({}, 0, 0); angular_velocity (0, 0, {}) }}",
      hz, 3 * hz, 10 * slope, floor, object, speed, -2 * speed);
}

struct Roller {
  const char* text;
  double gyration;  ///< k^2 / r^2
};
const Roller kBall{"type sphere", 0.4};
const Roller kCylinder{"type cylinder; aspect 1 : 2 : 1; orientation (pi / 2, 0, 0)", 0.5};
/// A cylinder and two half balls of radius 1/2 and height 1: (V_c / 2 + V_s 2/5) / V.
const Roller kCapsule{"type capsule; aspect 1 : 2 : 1; orientation (pi / 2, 0, 0)",
                      (3.0 / 4 * 0.5 + 0.5 * 0.4) / (3.0 / 4 + 0.5)};

TEST(RollWatch, IsTheErrorOfTheSpeedDownASlope) {
  int off = 0;
  for (const Roller& shape : {kBall, kCylinder, kCapsule})
    for (const double slope : {0.03, 0.05, 0.1})
      for (const char* floor : {"wall_shape plane", "wall_shape box"}) {
        SCOPED_TRACE(fmt::format("{} on {}, {}", shape.text, floor, slope));
        const RollingRun rolled = RunRolling(Slope(shape.text, slope, 0.2, 60, floor));
        const double speed = 0.2 + 3 * 10 * slope / (1 + shape.gyration);
        // Of the speed at which it would roll if it does not slip.
        const double got =
            (rolled.velocity + shape.gyration * rolled.spin / 2) / (1 + shape.gyration);
        const double error = std::abs(got - speed) / std::max(rolled.velocity, std::sqrt(10) / 2);
        EXPECT_NEAR(rolled.rolling_error, error, 0.05 * error + 1e-3);
        EXPECT_EQ(rolled.verdict == protocol::Verdict::kDrifting, rolled.largest_error > 0.05);
        if (shape.gyration == kBall.gyration) {
          EXPECT_LT(rolled.rolling_error, 1e-3);
        }
        off += rolled.rolling_error > 0.05;
      }
  EXPECT_GE(off, 2);
}

TEST(RollWatch, FallsWithTheTimeStep) {
  for (const Roller& shape : {kCylinder, kCapsule}) {
    const auto error_at = [&](int hz) {
      return RunRolling(Slope(shape.text, 0.05, 0, hz, "wall_shape plane")).rolling_error;
    };
    EXPECT_LT(error_at(480), error_at(60) / 3) << shape.text;
  }
}

TEST(RollWatch, IsNothingWithAWholeLineOfContact) {
  for (const Roller& shape : {kCylinder, kCapsule})
    for (const char* floor : {"wall_shape plane", "wall_shape box"})
      for (const int hz : {60, 240}) {
        SCOPED_TRACE(fmt::format("{} on {} at {} Hz", shape.text, floor, hz));
        const std::string slope = Slope(shape.text, 0.05, 0.2, hz, floor);
        const RollingRun rolled = RunRolling("narrow_phase batch\n" + slope);
        EXPECT_LT(rolled.largest_error, 2e-5);
        EXPECT_LT(rolled.largest_error, RunRolling(slope).largest_error / 100);
        EXPECT_EQ(rolled.verdict, protocol::Verdict::kStable);
      }
}

TEST(RollWatch, FrictionChangesNothing) {
  // Slips at first, then rolls at 5/7 of the speed.
  for (const char* floor : {"wall_shape plane", "wall_shape box"}) {
    const RollingRun rolled = RunRolling(
        fmt::format("timestep 1/60; cycles 180; acceleration (0, -10, 0)\n"
                    "world {{ side 200; walls floor; wall_friction 1; {} }}\n"
                    "objects {{ quantity 1; size 1; friction 0.4; location at(-50, -99.4999, 0)\n"
                    "type sphere; linear_velocity (7, 0, 0) }}",
                    floor));
    EXPECT_NEAR(rolled.velocity, 5, 0.01);
    EXPECT_NEAR(rolled.spin, 10, 0.02);
    EXPECT_LT(rolled.rolling_error, 1e-3);
    EXPECT_EQ(rolled.verdict, protocol::Verdict::kStable);
  }
}

TEST(RollWatch, LeavesOutWhatResists) {
  for (const char* resists : {"rolling_friction 0.01", "linear_damping 0.1", "angular_damping 0.1",
                              "type cuboid", "aspect 1 : 1 : 2"})
    EXPECT_TRUE(
        std::isnan(RunRolling(Slope(fmt::format("{}", resists), 0.05, 0, 60, "wall_shape plane"))
                       .rolling_error))
        << resists;
}

}  // namespace
}  // namespace cdb::tests
