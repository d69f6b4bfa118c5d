// The numbers that lints compute from a scene before it runs.
#include "compiler/lints/lints.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "compiler/lints/lint_facts.h"
#include "compiler/schema/schema.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

compiler::Compilation CompileStatements(const std::string& statements) {
  compiler::Compilation result = CompileText("benchmark b {\n" + statements + "\n}\n");
  EXPECT_FALSE(result.diagnostics.has_errors());
  return result;
}

std::optional<lints::LintNumber> NumberOf(lints::Lint lint, const std::string& statements) {
  const auto numbers = lints::LintScene(CompileStatements(statements).plans.at(0).runs.at(0).scene);
  const auto found = std::ranges::find(numbers, lint, &lints::LintNumber::lint);
  return found == numbers.end() ? std::nullopt : std::optional(*found);
}

TEST(Lints, AreOneRowEachAboutParametersOfTheSchema) {
  std::set<std::string_view> names;
  int index = 0;
  for (const lints::LintInfo& info : lints::Lints()) {
    EXPECT_EQ(static_cast<int>(info.lint), index++);
    EXPECT_EQ(&lints::InfoOf(info.lint), &info);
    EXPECT_TRUE(lints::IsLint(info.kind));
    EXPECT_EQ(info.kind.severity(), dsl::Severity::kWarning);
    EXPECT_TRUE(names.insert(info.kind.id).second) << info.kind.id;
    EXPECT_NE(info.predicts.find("{}"), std::string_view::npos) << info.predicts;
    std::string_view about = info.about;
    while (!about.empty()) {
      const std::string_view name = about.substr(0, about.find(' '));
      about.remove_prefix(std::min(about.size(), name.size() + 1));
      EXPECT_TRUE(schema::FindParameter(name, false) != nullptr ||
                  schema::FindParameter(name, true) != nullptr)
          << name;
    }
  }
}

TEST(Lints, AreTheirFormulae) {
  const auto stack =
      NumberOf(lints::Lint::kTallStack,
               "objects { quantity 20; size 2; location stack }; solver.iterations 5");
  ASSERT_TRUE(stack);
  EXPECT_DOUBLE_EQ(stack->value, 20 * 20 * 9.8 / 3600 / (2 * 5));
  const auto step = NumberOf(lints::Lint::kLongStep, "objects.size 0.5");
  ASSERT_TRUE(step);
  EXPECT_DOUBLE_EQ(step->value, 9.8 / 3600 / 0.5);
  EXPECT_DOUBLE_EQ(NumberOf(lints::Lint::kFastSpin, "objects.angular_velocity (30, 0, 40)")->value,
                   50. / 60);
  EXPECT_DOUBLE_EQ(NumberOf(lints::Lint::kHeavyMass, "objects.mass uniform(1, 500)")->value, 500);
  const auto spring = NumberOf(lints::Lint::kStiffSpring,
                               "objects { quantity 1; links { type spring; stiffness 400 } }");
  ASSERT_TRUE(spring);
  EXPECT_NEAR(spring->value, 20. / 60, 1e-12);
}

/// A light link between heavy ones, held by the world or standing on the floor.
TEST(Lints, LightLinksBetweenHeavyOnesComeApart) {
  const auto number = [](const std::string& statements, int g = 10) {
    return NumberOf(
        lints::Lint::kHeavyEnd,
        "acceleration (0, -" + std::to_string(g) +
            ", 0); timestep 0.01; cycles 1000; sleeping off; solver.iterations 10; "
            "objects a { quantity 1; type cuboid; size 1; mass 2; location at(0, 0, 0) } objects b "
            "{ "
            "quantity 1; type cuboid; size 1; mass 0.5; location relative_to(a, (0, -1.5, 0)) } "
            "objects "
            "c { quantity 1; type cuboid; size 1; mass 30; location relative_to(b, (0, -1.5, 0)) } "
            "joints ab { parent a; child b; type hinge; at (0, -0.75, 0) } joints bc { parent b; "
            "child "
            "c; type hinge; at (0, -0.75, 0) } " +
            statements);
  };
  constexpr const char* kHeld =
      "world { side 20; walls none } joints j { parent world; child a; type hinge; at (0, 0.5, 0) "
      "}";
  const auto held = number(kHeld);
  ASSERT_TRUE(held);
  EXPECT_NEAR(held->value, 30 / 0.5 * 10 * 1e-4 / (10 * 0.2), 1e-9);
  EXPECT_FALSE(held->open);
  EXPECT_FALSE(number(std::string(kHeld) + " coordinates reduced"));
  EXPECT_FALSE(number(kHeld, 0));
  const auto standing = number("world { side 20; walls floor }");
  ASSERT_TRUE(standing);
  EXPECT_NEAR(standing->value, 30 / 0.5 * 10 * 1e-4 / (10 * 0.2), 1e-9);
  EXPECT_TRUE(standing->open) << "the floor may carry c";
  EXPECT_FALSE(number("world { side 20; walls none }")) << "it falls, and nothing pulls";
}

TEST(Lints, MotorsThatTurnTooFastAreNamed) {
  const auto value = [](const std::string& motor) {
    const auto number =
        NumberOf(lints::Lint::kFastSpin,
                 "timestep 0.01; cycles 100; acceleration 0; objects w { quantity 1; type cuboid; "
                 "size 1; mass 6; location at(0, 0, 0) } joints j { parent world; child w; type "
                 "hinge; at (0, 0, 0); axis (0, 0, 1); " +
                     motor + " }");
    EXPECT_TRUE(!number || number->open);
    return number ? number->value : 0;
  };
  EXPECT_NEAR(value("motor { velocity 200 rad/s; effort 10 }"), 2, 1e-12);
  EXPECT_NEAR(value("motor { torque 300 }"), 300 * 1 / 1.0 * 0.01, 1e-12);
  EXPECT_EQ(value("damping 1; motor { torque 300 }"), 0) << "it has a speed that it comes to";
  EXPECT_EQ(value("motor { position 1; effort 10 }"), 0);
}

/// A rope with free ends has the frequency 2 sqrt(k / m), m the mass of a node within; the power
/// iteration comes close to it from below.
TEST(Lints, SoftSpringsExplodeWhereTheHighestFrequencyIsTooHigh) {
  const auto number = [](const std::string& soft) {
    return NumberOf(
        lints::Lint::kStiffSpring,
        "timestep 0.01; soft_world springs; world.walls none; objects { quantity 1; size "
        "2; mass 2; type rope(segments: 20); soft { " +
            soft + " } }");
  };
  EXPECT_FALSE(number("stiffness 500")) << "0.7 of the limit";
  const auto beyond = number("stiffness 2000");
  ASSERT_TRUE(beyond);
  EXPECT_NEAR(beyond->value, 2 * std::sqrt(2000 / 0.1) * 0.01, 0.02);
  EXPECT_TRUE(beyond->IsBad());
  EXPECT_LT(beyond->remedy, 0.01 * std::sqrt(0.5));
  EXPECT_GT(beyond->remedy, 0.006);
  const auto damped = number("stiffness 2000; damping 1");
  ASSERT_TRUE(damped);
  EXPECT_LT(damped->value, beyond->value);
  EXPECT_FALSE(
      NumberOf(lints::Lint::kTallStack,
               "world { side 10; wall_shape box } objects { quantity 1; size 2; mass 2; type "
               "cloth(columns: 2, rows: 2) }"));
}

/// Cells of 0.1 m with sqrt(E / density) = 10 m/s, a Poisson's ratio of 0.3 and no pins: 413 rad/s
/// by the eigenvalues of the assembled stiffness (block_test.cc), however many they are.
TEST(Lints, BlocksExplodeWhereTheirHighestFrequencyIsTooHigh) {
  const auto number = [](int cells, const std::string& soft) {
    return NumberOf(
        lints::Lint::kStiffSpring,
        fmt::format("timestep 0.006; soft_world springs; world.walls none; objects {{ quantity 1; "
                    "size {}; mass {}; type block(columns: {}, rows: 3, layers: 3); aspect 1 : "
                    "{:.12g} : {:.12g}; soft {{ {} }} }}",
                    0.1 * cells, 9 * cells, cells, 3.0 / cells, 3.0 / cells, soft));
  };
  for (const int cells : {3, 40}) {
    const auto beyond = number(cells, "young_modulus 1e5");
    ASSERT_TRUE(beyond);
    EXPECT_NEAR(beyond->value, 413 * 0.006, 0.01);
    EXPECT_TRUE(beyond->IsBad());
    EXPECT_NEAR(beyond->remedy, 0.9 * 2 / 413, 0.0001);
  }
  EXPECT_FALSE(number(3, "young_modulus 5e4")) << "0.88 of the limit";
  EXPECT_LT(number(3, "young_modulus 1e5; stiffness_damping 0.001")->value, 413 * 0.006 * 0.9);
}

TEST(Lints, SayNothingWhereNothingCanHappen) {
  EXPECT_FALSE(NumberOf(lints::Lint::kTallStack, "acceleration 0; objects.location stack"));
  EXPECT_FALSE(NumberOf(lints::Lint::kLongStep, "world.walls none"));
  EXPECT_FALSE(NumberOf(lints::Lint::kThinWall, "world.wall_shape box; objects.ccd on"));
  EXPECT_FALSE(
      NumberOf(lints::Lint::kHeavyMass, "objects { quantity 1; mass 1e9 }; world.walls none"));
  EXPECT_FALSE(NumberOf(lints::Lint::kSpinDrift, "objects.angular_velocity (1, 2, 3)"));
  EXPECT_FALSE(NumberOf(lints::Lint::kSpinDrift,
                        "objects { type cuboid; aspect 1 : 2 : 3; angular_velocity (0, 9, 0) }"));
  EXPECT_FALSE(
      NumberOf(lints::Lint::kFastSpin, "objects { mass fixed; angular_velocity (9, 9, 9) }"));
  EXPECT_TRUE(
      lints::LintScene(CompileStatements("objects.quantity 0").plans[0].runs[0].scene).empty());
}

TEST(Lints, KnowWhatMayMeetInFreeFlight) {
  const std::string ball =
      "acceleration 0; world { side 1000; walls none }; cycles 60\n"
      "objects ball { quantity 1; size 0.2; location at(-10, 0, 0); linear_velocity (100, 0, 0) "
      "}\n";
  const auto plate = [](const std::string& rest) {
    return "objects plate { quantity 1; type cuboid; size 0.1; aspect 1 : 40 : 40; " + rest + " }";
  };
  using enum lints::Lint;
  EXPECT_TRUE(NumberOf(kThinWall, ball + plate("mass fixed; location at(0, 0, 0)"))->IsBad());
  EXPECT_FALSE(NumberOf(kThinWall, ball + plate("mass fixed; location at(0, 2.2, 0)")));
  EXPECT_FALSE(
      NumberOf(kThinWall, ball + plate("mass fixed; location at(0, 0, 0); collides_with none")));
  // The plate comes to meet it, or flies beside it at its speed.
  const std::string free = "location at(0, 2, 0); linear_velocity ";
  EXPECT_TRUE(NumberOf(kThinShape, ball + plate(free + "(0, 0, 0)")));
  EXPECT_FALSE(NumberOf(kThinShape, ball + plate(free + "(100, 0, 0)")));
}

TEST(Lints, SeeTheGapThatAPressCloses) {
  const auto press = [](const std::string& ball, const std::string& velocity) {
    return NumberOf(lints::Lint::kCrush,
                    "cycles 60; world { side 20; walls floor }\n"
                    "objects ball { quantity 1; size 1; location " +
                        ball +
                        " }\n"
                        "objects press { quantity 1; type cuboid; size 4; mass kinematic\n"
                        "location at(0, -6, 0); linear_velocity (0, " +
                        velocity + ", 0) }");
  };
  // 2 m between press and floor, 1 m of it beside the ball, and a second's time.
  const auto slow = press("at(0, -9.4, 0)", "-0.5");
  ASSERT_TRUE(slow);
  EXPECT_NEAR(slow->value, 0.5, 1e-9);
  EXPECT_FALSE(slow->IsBad());
  EXPECT_TRUE(press("at(0, -9.4, 0)", "-1.5")->IsBad());
  EXPECT_FALSE(press("at(6, -9.4, 0)", "-1.5")->IsBad());
  EXPECT_FALSE(press("at(0, -9.4, 0)", "1.5"));
}

TEST(Lints, SeeAStackOfListedObjects) {
  const auto tower = [](const std::string& second) {
    return NumberOf(lints::Lint::kTallStack,
                    "objects { type cuboid; size 1; location at((0, 0.5, 0), " + second + ") }");
  };
  ASSERT_TRUE(tower("(0.2, 1.5, 0)"));
  EXPECT_DOUBLE_EQ(tower("(0.2, 1.5, 0)")->value, 4 * 9.8 / 3600 / 10);
  EXPECT_FALSE(tower("(0, 3, 0)"));
  EXPECT_FALSE(tower("(2, 1.5, 0)"));
}

TEST(Lints, MeasurePlacesOfALatticeByItsSpacing) {
  const auto coarse = [](const std::string& spacing) {
    return NumberOf(
               lints::Lint::kCoarsePlace,
               "world.side 200e3; objects { quantity 27; size 1; location grid" + spacing + " }")
        ->value;
  };
  const double epsilon = std::ldexp(1.0, -23);
  EXPECT_DOUBLE_EQ(coarse("(spacing: 4)"), 4 * epsilon);
  EXPECT_DOUBLE_EQ(coarse(""), 65536 * epsilon);
}

TEST(Lints, CountAFallFromWhereAnObjectStarts) {
  const std::string domino = "type cuboid; size 0.5; aspect 1 : 2 : 0.4; location at(0, -4.45, 0)";
  const auto fall =
      NumberOf(lints::Lint::kFastHit, "world.side 10; objects { quantity 1; " + domino + " }");
  ASSERT_TRUE(fall);
  // From its position to where its thinnest side lies on the floor.
  EXPECT_NEAR(fall->value, std::sqrt(2 * 9.8 * (0.55 - 0.1)) / 60 / 0.2, 1e-9);
  EXPECT_FALSE(fall->IsDoubtful());
  // On a slope it slides across the cube.
  const auto slide = NumberOf(lints::Lint::kFastHit,
                              "world.side 10; cycles 1000; acceleration (20, -9.7, 0)\n"
                              "objects { quantity 1; " +
                                  domino + " }");
  ASSERT_TRUE(slide);
  EXPECT_NEAR(slide->value, std::sqrt(2 * 20 * 10.) / 60 / 0.2, 1e-9);
  EXPECT_TRUE(slide->IsDoubtful());
}

/// Cubes of 0.05 to 0.2 m, 2 to 6 high, at 60 to 480 Hz: the pull at which stacks fell in Bullet.
TEST(Lints, PredictThatAStackPulledAsideFalls) {
  struct Case {
    int n, hz;
    double size, holds, falls;
  };
  for (const Case& seen :
       {Case{2, 60, 0.2, 0.05, 0.2}, Case{4, 60, 0.2, 0.01, 0.05}, Case{4, 120, 0.2, 0.02, 0.05},
        Case{4, 480, 0.2, 0.1, 0.2}, Case{6, 240, 0.2, 0.02, 0.05}, Case{6, 480, 0.2, 0.05, 0.1},
        Case{4, 240, 0.05, 0.02, 0.045}, Case{5, 240, 0.05, 0.01, 0.03}}) {
    const auto number = [&](double pull) {
      return NumberOf(lints::Lint::kLeaningStack,
                      fmt::format("timestep 1 / {}; cycles {}; world.side 20; expect rest\n"
                                  "acceleration ({}, -9.8, 0)\n"
                                  "objects {{ quantity {}; type cuboid; size {}; location stack }}",
                                  seen.hz, 4 * seen.hz, 9.8 * pull, seen.n, seen.size));
    };
    ASSERT_TRUE(number(seen.falls));
    EXPECT_GE(number(seen.falls)->Severity(), 1) << seen.n << " at " << seen.hz;
    EXPECT_FALSE(number(seen.falls)->IsBad());
    EXPECT_LT(number(seen.holds)->Severity(), 1.35) << seen.n << " at " << seen.hz;
  }
  EXPECT_FALSE(NumberOf(lints::Lint::kLeaningStack, "acceleration (1, -9, 0)"));
}

TEST(Lints, SeeALoadOnAStack) {
  const auto ratio = [](const std::string& place, const std::string& stack) {
    return NumberOf(lints::Lint::kMassRatio,
                    "world.side 20\n"
                    "objects light { quantity 5; type cuboid; size 1; location " +
                        stack +
                        " }\n"
                        "objects heavy { quantity 1; type cuboid; size 1; mass 100; location " +
                        place + " }");
  };
  const auto on_top = ratio("at(0.3, -4, 0)", "stack");
  ASSERT_TRUE(on_top);
  EXPECT_DOUBLE_EQ(on_top->value, 100. / 10 * 0.6 * 5);
  EXPECT_TRUE(on_top->IsBad());
  // Beside it; on the second of two columns; between columns.
  EXPECT_LE(ratio("at(2, -9, 0)", "stack")->value, 0.1);
  EXPECT_GT(ratio("at(2, -4, -2)", "stack(height: 3, spacing: 4)")->value, 10);
  EXPECT_LE(ratio("at(0, -4, 2)", "stack(height: 3, spacing: 4)")->value, 0.1);
  EXPECT_GT(ratio("at(0, -4, 0)", "pyramid")->value, 10);
}

TEST(Lints, PredictThatABallPassesThroughASlab) {
  const auto scene = [](const std::string& velocity, const std::string& place) {
    return "acceleration 0; world { side 100; walls none }\n"
           "objects ball { quantity 1; size 0.2; location " +
           place + "; linear_velocity " + velocity +
           " }\n"
           "objects slab { quantity 1; type cuboid; size 0.1; aspect 1 : 40 : 40; mass fixed\n"
           "  location at(0, 0, 0) }";
  };
  const std::string hits = scene("(100, 0, 0)", "at(-5, 0, 0)");
  const auto wall = NumberOf(lints::Lint::kThinWall, hits);
  ASSERT_TRUE(wall);
  EXPECT_NEAR(wall->value, 100. / 60 / 0.3, 1e-9);
  EXPECT_TRUE(wall->IsBad());
  EXPECT_FALSE(NumberOf(lints::Lint::kFastHit, hits));
  for (const auto& [velocity, place] : {std::pair{"(100, 0, 0)", "at(-5, 3, 0)"},
                                        {"(-100, 0, 0)", "at(-5, 0, 0)"},
                                        {"(100, 100, 0)", "at(-5, 0, 0)"}})
    EXPECT_FALSE(NumberOf(lints::Lint::kThinWall, scene(velocity, place))) << velocity;
  // Along the slab it is 4 m thick; at a drawn position the result is unknown.
  EXPECT_FALSE(
      NumberOf(lints::Lint::kThinWall, scene("(0, 100, 0)", "at(0, -5, 0)"))->IsDoubtful());
  const auto drawn = NumberOf(lints::Lint::kThinWall, scene("(100, 0, 0)", "uniform"));
  EXPECT_TRUE(drawn->IsDoubtful() && !drawn->IsBad());
}

TEST(Lints, LetSmallBallsLie) {
  const std::string marble = "world.side 0.2; objects { quantity 1; size 0.01; location ";
  EXPECT_FALSE(NumberOf(lints::Lint::kLongStep, marble + "at(0, -0.095, 0) }"));
  EXPECT_FALSE(NumberOf(lints::Lint::kLongStep, marble + "stack }"));
  // One that falls may be pushed out of the floor without flying up.
  const auto falls = NumberOf(lints::Lint::kLongStep, marble + "at(0, -0.09, 0) }");
  EXPECT_TRUE(falls->IsDoubtful() && !falls->IsBad());
  EXPECT_TRUE(NumberOf(lints::Lint::kLongStep, marble + "stack; type cuboid }")->IsBad());
  const auto on_box =
      NumberOf(lints::Lint::kLongStep, "world.wall_shape box; " + marble + "stack }");
  EXPECT_EQ(on_box->threshold, 5);
  EXPECT_FALSE(on_box->IsDoubtful());
}

TEST(Lints, SeeTheFirstFallThatRoundingHides) {
  const auto fall = [](const std::string& side, const std::string& more = "") {
    return NumberOf(
        lints::Lint::kLostFall,
        "objects { quantity 100; size 1; type any(sphere, armadillo) }; world.side " + side + more);
  };
  // Adjacent floats are 1/64 m apart from 131,072 m on; the relevant distance is 1 cm.
  EXPECT_NEAR(fall("300e3")->value, 1. / 64 / 0.01, 1e-9);
  EXPECT_TRUE(fall("300e3")->IsBad());
  EXPECT_TRUE(fall("100e3")->IsBad());
  EXPECT_FALSE(fall("50e3")->IsBad());
  EXPECT_FALSE(fall("300e3", "; precision double")->IsDoubtful());
  EXPECT_FALSE(fall("300e3", "; acceleration 0"));
  EXPECT_FALSE(fall("300e3", "; objects.linear_velocity uniform(-9, 9)"));
  // The paper's own objects are so large that the loss of the first cycles changes nothing.
  for (const char* type : {"sphere", "armadillo"})
    EXPECT_FALSE(NumberOf(lints::Lint::kLostFall,
                          "objects { quantity 5000; type " + std::string(type) + " }")
                     ->IsDoubtful());
}

TEST(Lints, WithTheirRemedyAreHarmless) {
  const auto bad = NumberOf(lints::Lint::kLongStep, "objects { type cuboid; size 0.05 }");
  ASSERT_TRUE(bad && bad->IsBad());
  const auto mended =
      NumberOf(lints::Lint::kLongStep,
               "objects { type cuboid; size 0.05 }; timestep " + schema::FormatReal(bad->remedy));
  EXPECT_FALSE(mended->IsDoubtful());
  EXPECT_LT(mended->Severity(), lints::LintNumber::kDoubtful);
}

TEST(Lints, CountTheRunsAndPointAtTheWorst) {
  const compiler::Compilation result =
      CompileStatements("timestep sweep(1 / 1000, 1 / 20); objects.size 0.2");
  ASSERT_EQ(result.diagnostics.all().size(), 1u);
  const dsl::Diagnostic& warning = result.diagnostics.all()[0];
  EXPECT_EQ(warning.kind, &lints::InfoOf(lints::Lint::kLongStep).kind);
  EXPECT_NE(warning.message.find("in 1 of 2 runs"), std::string::npos) << warning.message;
  EXPECT_EQ(warning.span.begin, std::string("benchmark b {\ntimestep sweep(1 / 1000, ").size());
}

TEST(Lints, LeaveOutBenchmarksThatWereNotAskedFor) {
  const std::string text = "benchmark a { }\nbenchmark b { objects.size 0.01 }\n";
  const auto warnings = [&](const std::string& benchmark) {
    const auto read = [&](const std::string&, std::string&) { return std::optional(text); };
    return compiler::Compile("test.cdb", read, {"lib", benchmark}).diagnostics.warning_count();
  };
  EXPECT_EQ(warnings("a"), 0);
  EXPECT_EQ(warnings("b"), 1);
}

TEST(Bounds, AreOfEachKindOfValue) {
  const auto drawn = [](schema::DistributionKind kind, schema::Value a, schema::Value b) {
    return schema::Value(schema::Distribution{kind, {std::move(a), std::move(b)}, {}});
  };
  EXPECT_EQ(lints::PositiveBounds(schema::Value(3.0)).least, 3);
  EXPECT_EQ(lints::PositiveBounds(drawn(schema::DistributionKind::kUniform, 2.0, 5.0)).most, 5);
  EXPECT_EQ(lints::PositiveBounds(drawn(schema::DistributionKind::kNormal, 50.0, 10.0)).least, 20);
  EXPECT_EQ(lints::PositiveBounds(drawn(schema::DistributionKind::kNormal, 10.0, 10.0)).least,
            0.04);
  EXPECT_EQ(lints::PositiveBounds(schema::Value(schema::Word{"fixed"})).most, 0);
  EXPECT_EQ(lints::LargestComponents(drawn(schema::DistributionKind::kUniform, -4.0, 3.0)),
            Vector3d(4, 4, 4));
  EXPECT_EQ(lints::LargestComponents(
                drawn(schema::DistributionKind::kNormal, Vector3d(1, 0, -1), Vector3d(1, 2, 3))),
            Vector3d(4, 6, 10));
}

}  // namespace
}  // namespace cdb::tests
