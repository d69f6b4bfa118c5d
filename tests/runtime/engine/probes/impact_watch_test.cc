// Impacts: what the series say against closed forms, and that the error falls with the time step.
#include "runtime/engine/probes/impact_watch.h"

#include <fmt/format.h>

#include <cmath>
#include <random>

#include "dsl/diagnostics.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

struct ImpactRun {
  double error;    ///< the largest; NaN if nothing was judged
  Vector3d first;  ///< m/s: velocity of the first object at the end
  protocol::Verdict verdict;
};

ImpactRun RunImpact(const std::string& text) {
  const compiler::Compilation compiled =
      CompileText(fmt::format("benchmark b {{ precision {}; sleeping off; record stability\n{} }}",
                              world::EnginePrecision(), text));
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  const plan::Scene& scene = compiled.plans.at(0).runs.at(0).scene;
  const Recorded run = RunHere(scene);
  EXPECT_TRUE(run.done()) << run.message();
  double error = std::numeric_limits<double>::quiet_NaN();
  for (const double value : run.recording.Reals("impact_error")) error = std::fmax(error, value);
  return {error, Velocity(*run.engine),
          protocol::Judge(scene, run.recording, scene.world.Count("cycles")).verdict};
}

/// A ball of 1 kg and 1 m meets another at rest, `offset` beside its path.
std::string Balls(double speed, double offset, double start, double e, int hz,
                  const std::string& more = "friction 0") {
  return fmt::format(
      "timestep 1/{0}; cycles 2 * {0}; acceleration 0; contact faithful; world {{ side 200; walls "
      "none }}\n"
      "objects a {{ quantity 1; size 1; restitution {1}; {5}; location at({2}, 0, 0)\n"
      "linear_velocity ({3}, 0, 0) }}\n"
      "objects b {{ quantity 1; size 1; restitution 1; {5}; location at(0, {4}, 0) }}",
      hz, e, start, speed, -offset, more);
}

TEST(ImpactWatch, FindsTheDirectionInWhichBallsPart) {
  int off = 0;
  for (const double speed : {2., 6., 12.})
    for (const double offset : {0., 0.3, 0.6, 0.8})
      for (const double start : {-3., -3.03, -3.07})
        for (const double e : {0., 0.5, 1.}) {
          SCOPED_TRACE(fmt::format("{} m/s, {} beside, from {}, e = {}", speed, offset, start, e));
          const ImpactRun run = RunImpact(Balls(speed, offset, start, e, 60));
          const Vector3d normal(-std::sqrt(1 - offset * offset), offset, 0);
          const Vector3d impulse = -(1 + e) / 2 * speed * normal.x() * normal;
          const double error = (run.first - Vector3d(speed, 0, 0) - impulse).norm();
          EXPECT_NEAR(run.error, error / impulse.norm(), 5e-4);
          EXPECT_EQ(run.error > 0.125, run.verdict == protocol::Verdict::kDrifting);
          off += run.error > 0.1;
        }
  EXPECT_GT(off, 3) << "Bullet has become better";
}

TEST(ImpactWatch, FindsErrorsThatFallWithTheTimeStep) {
  // Order 1 gives a factor of 8. Medians, as single edges of cubes are met otherwise with another
  // step.
  for (const auto& [type, factor] : {std::pair("sphere", 5), {"cuboid", 2}}) {
    double medians[2] = {};
    for (int fine = 0; fine < 2; ++fine) {
      std::mt19937 random(7);
      const auto between = [&](double from, double to) {
        return from + (to - from) * (random() / 4294967296.);
      };
      std::vector<double> errors;
      for (int scene = 0; scene < 24; ++scene) {
        // One after the other: the order of arguments is the compiler's.
        double drawn[8];
        for (double& number : drawn) number = between(0, 1);
        const auto at = [&](int i, double from, double to) {
          return from + (to - from) * drawn[i];
        };
        const std::string more = fmt::format("type {}; friction {}; orientation ({}, {}, {})", type,
                                             drawn[4], at(5, -3, 3), at(6, -3, 3), at(7, -3, 3));
        const ImpactRun run = RunImpact(Balls(at(0, 2, 6), at(1, 0, 0.8), at(2, -3, -2.9), drawn[3],
                                              fine == 1 ? 480 : 60, more));
        if (!std::isnan(run.error)) errors.push_back(run.error);
      }
      ASSERT_GT(errors.size(), 12u) << type;
      std::ranges::nth_element(errors,
                               errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2));
      medians[fine] = errors[errors.size() / 2];
    }
    EXPECT_GT(medians[0], 2e-3) << type;
    EXPECT_LT(medians[1], medians[0] / factor) << type;
  }
}

/// A ball that hits the wall at x = 10 obliquely.
std::string AgainstWall(double e, double mu, int hz, const std::string& contact) {
  return fmt::format(
      "timestep 1/{0}; cycles {0}; acceleration 0; contact {3}\n"
      "world {{ side 20; wall_friction 1 }}\n"
      "objects {{ quantity 1; size 1; restitution {1}; friction {2}; location at(7, 0, 0)\n"
      "linear_velocity (5, 3, 0) }}",
      hz, e, mu, contact);
}

TEST(ImpactWatch, FindsNothingWhereABallMeetsAWall) {
  for (const double e : {0., 0.5, 1.})
    for (const double mu : {0., 0.05, 0.2, 1.}) {
      const ImpactRun run = RunImpact(AgainstWall(e, mu, 60, "faithful"));
      EXPECT_LT(run.error, 0.01) << e << " " << mu;
      const double change = std::min(mu * (1 + e) * 5, 2. / 7 * 3);
      EXPECT_LT((run.first - Vector3d(-5 * e, 3 - change, 0)).norm(), 0.02);
    }
}

TEST(ImpactWatch, FindsReboundsWithoutRestitution) {
  // Bullet pushes shallow overlaps apart by a fifth of their depth in a cycle.
  const auto met = [](double start, const char* contact) {
    return RunImpact(
        fmt::format("timestep 1/60; cycles 120; acceleration 0; contact {}\n"
                    "world {{ side 200; walls none }}\n"
                    "objects a {{ quantity 1; size 1; location at({}, 0, 0)\n"
                    "linear_velocity (2, 0, 0) }}\n"
                    "objects b {{ quantity 1; size 1; location at(0, 0, 0) }}",
                    contact, start));
  };
  const ImpactRun bad = met(-3, "bullet");
  EXPECT_NEAR(bad.first.x(), 0.8, 0.01);
  EXPECT_NEAR(bad.error, 0.2, 0.01);
  EXPECT_EQ(bad.verdict, protocol::Verdict::kDrifting);
  EXPECT_LT(met(-3, "faithful").error, 0.01);
  // Foreseen, it takes two cycles.
  const ImpactRun foreseen = met(-3.0 - 0.005, "bullet");
  EXPECT_NEAR(foreseen.error, std::abs(foreseen.first.x() - 1), 0.02);
}

TEST(ImpactWatch, FindsFlatObjectsThatAreHitBesideTheirMiddle) {
  const auto meet = [](const char* type, double offset, const char* more) {
    return RunImpact(fmt::format(
        "cycles 60; contact faithful; world {{ side 60; walls floor; wall_friction 1; {} }}\n"
        "objects a {{ quantity 1; type {}; size 1; aspect 1 : 0.5 : 1; restitution 1; friction 0\n"
        "location at(-3, -29.75, 0); linear_velocity (5, 0, 0) }}\n"
        "objects b {{ quantity 1; type {}; size 1; aspect 1 : 0.5 : 1; restitution 1; friction 0\n"
        "location at(0, -29.75, {}) }}",
        more, type, type, -offset));
  };
  for (const char* walls : {"", "wall_shape box"}) {
    const ImpactRun discs = meet("cylinder", 0.6, walls);
    EXPECT_GT(discs.error, 0.1) << walls;
    EXPECT_NE(discs.verdict, protocol::Verdict::kStable);
  }
  // A ball meets a ball in the plane of the floor whatever the floor does.
  EXPECT_LT(meet("capsule", 0, "wall_shape box").error, 0.1);
}

TEST(ImpactWatch, JudgesNothingAtRest) {
  const ImpactRun stack = RunImpact(
      "cycles 120; world { side 40; walls floor; wall_shape box }\n"
      "objects { quantity 5; type cuboid; size 1; location stack }");
  EXPECT_FALSE(stack.error > 0.01) << stack.error;
  // Nor what slides over edges of the ground, which is no impact.
  const ImpactRun slides = RunImpact(
      "cycles 120; world { side 100; walls none }\n"
      "objects a { quantity 1; type cuboid; size 1; friction 0.1; location at(-3, 1, 0.3)\n"
      "linear_velocity (4, 0, 0) }\n"
      "objects floor { quantity 3; type cuboid; size 4; aspect 1 : 0.25 : 1; mass fixed\n"
      "location at((-4, 0, 0), (0, 0, 0), (4, 0, 0)) }");
  EXPECT_FALSE(slides.error > 0.1) << slides.error;
}

TEST(ImpactWatch, ExaminesDirectionsInACrowd) {
  // The middle one of three balls in a row is hit beside the line of centres: it touches another
  // that is free to move, so that only the direction of the impulse is certain.
  const ImpactRun run = RunImpact(
      "timestep 1/60; cycles 60; acceleration 0; contact faithful; world { side 200; walls none }\n"
      "objects a { quantity 1; size 1; restitution 1; friction 0; location at(-3.05, 0.5, 0)\n"
      "linear_velocity (12, 0, 0) }\n"
      "objects b { quantity 2; size 1; restitution 1; friction 0\n"
      "location at((0, 0, 0), (1.0005, 0, 0)) }");
  EXPECT_GT(run.error, 0.05);
}

/// A ball of 0.1 m that flies along x over the upper edge of a fixed cube of 0.4 m on its edge,
/// which is at the origin.
struct OverEdge {
  double height, start, speed, e;
  std::string Text() const {
    return fmt::format(
        "cycles 30; acceleration 0; contact faithful; world {{ side 200; walls none }}\n"
        "objects a {{ quantity 1; size 0.1; restitution {}; friction 0; location at({}, {}, 0)\n"
        "linear_velocity ({}, 0, 0) }}\n"
        "objects b {{ quantity 1; type cuboid; size 0.4; mass fixed; restitution 1; friction 0\n"
        "location at(0, {}, 0); orientation (0, 0, pi / 4) }}",
        e, start, height, speed, -0.4 / std::sqrt(2.));
  }
  /// m/s, after the impact: the edge is a point.
  Vector3d After() const {
    const Vector3d velocity(speed, 0, 0);
    if (height >= 0.05) return velocity;
    const Vector3d normal(-std::sqrt(0.05 * 0.05 - height * height) / 0.05, height / 0.05, 0);
    return velocity - (1 + e) * velocity.dot(normal) * normal;
  }
};

TEST(ImpactWatch, FindsImpactsThatBulletMisses) {
  const OverEdge missed{0.048, -0.255, 1.8, 0};
  const ImpactRun run = RunImpact(missed.Text());
  EXPECT_NEAR(run.first.x(), 1.8, 1e-6) << "Bullet has become better";
  EXPECT_NEAR(run.error, std::sqrt(1 - 0.96 * 0.96), 1e-3);
  EXPECT_EQ(run.verdict, protocol::Verdict::kDrifting);
  // A graze hardly counts, and a pass above the edge not at all.
  EXPECT_LT(RunImpact(OverEdge{0.0499, -0.255, 1.8, 0}.Text()).error, 0.08);
  EXPECT_TRUE(std::isnan(RunImpact(OverEdge{0.0501, -0.255, 1.8, 0}.Text()).error));
}

TEST(ImpactWatch, AgreesWithClosedFormsWhetherBulletFindsAnImpactOrNot) {
  std::mt19937 random(11);
  const auto between = [&](double from, double to) {
    return from + (to - from) * (random() / 4294967296.);
  };
  int missed = 0, found = 0, clear = 0;
  for (int scene = 0; scene < 60; ++scene) {
    const double speed = 6 * between(0.3, 1.4);  // of the ball's size in a cycle
    const OverEdge over{between(0.02, 0.055), -0.3 - between(0, speed / 60), speed,
                        scene % 2 == 0 ? 0. : 0.7};
    SCOPED_TRACE(over.Text());
    const ImpactRun run = RunImpact(over.Text());
    const Vector3d start(speed, 0, 0);
    const double change = (over.After() - start).norm(), error = (over.After() - run.first).norm();
    const bool is_missed = (run.first - start).norm() < 1e-3 * speed;
    clear += change == 0;
    missed += is_missed && change > 0;
    found += !is_missed;
    const double ratio = is_missed ? error / std::max(change, speed) : error / change;
    if (change == 0) {
      EXPECT_TRUE(is_missed && run.verdict == protocol::Verdict::kStable);
    } else if (ratio < 0.11) {
      EXPECT_EQ(run.verdict, protocol::Verdict::kStable) << ratio;
    } else if (ratio > 0.14) {
      EXPECT_NE(run.verdict, protocol::Verdict::kStable) << ratio;
    }
  }
  EXPECT_GT(missed, 5);
  EXPECT_GT(found, 10);
  EXPECT_GT(clear, 3);
}

}  // namespace
}  // namespace cdb::tests
