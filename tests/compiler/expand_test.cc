// Semantics of the language: axes, lets, cases, bases, skips, files.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "compiler/plan/input_file.h"
#include "compiler/plan/plan.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

plan::Plan PlanOf(const std::string& text, std::map<std::string, std::string> others = {},
                  std::size_t index = 0) {
  compiler::Compilation result = CompileText(text, std::move(others));
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return index < result.plans.size() ? result.plans[index] : plan::Plan();
}

/// `name: 1 2 3` for each axis.
std::string Axes(const plan::Plan& plan) {
  std::string text;
  for (const plan::Axis& axis : plan.axes) {
    text += (text.empty() ? "" : "; ") + axis.name + ":";
    for (const plan::Coordinate& value : axis.values)
      text += " " + (value.index() == 0 ? schema::FormatReal(std::get<double>(value))
                                        : std::get<std::string>(value));
  }
  return text;
}

TEST(Sweep, RangesHitTheirEnd) {
  EXPECT_EQ(Axes(PlanOf("benchmark b { timestep sweep(0.1 .. 0.3 step 0.1) }")),
            "timestep: 0.1 0.2 0.3");
  EXPECT_EQ(Axes(PlanOf("benchmark b { cycles sweep(5 .. 1 step -2) }")), "cycles: 5 3 1");
  EXPECT_EQ(Axes(PlanOf("benchmark b { cycles sweep(1 .. 2.5) }")), "cycles: 1 2");
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects.mass sweep(1 .. 1000 count 4 log) }")),
            "mass: 1 10 100 1000");
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects.size sweep(0.5 .. 1.5 count 3) }")),
            "size: 0.5 1 1.5");
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects.size sweep(7 .. 9 count 1) }")), "size: 7");
  EXPECT_EQ(Axes(PlanOf("benchmark b { cycles sweep(1 .. 2, 10) }")), "cycles: 1 2 10");
}

TEST(Sweep, TheValuesOfRangesAreAsWritten) {
  const auto values = [](const std::string& range) {
    const plan::Plan plan = PlanOf("benchmark b { objects.mass sweep(" + range + ") }");
    std::vector<double> numbers;
    for (const auto& value : plan.axes.at(0).values) numbers.push_back(std::get<double>(value));
    return numbers;
  };
  const auto long_range = values("0.1 .. 100 step 0.1");
  ASSERT_EQ(long_range.size(), 1000u);
  for (std::size_t i = 0; i < 1000; ++i)
    EXPECT_EQ(long_range[i], std::stod(fmt::format("{}.{}", (i + 1) / 10, (i + 1) % 10)));
  EXPECT_EQ(values("60 .. 3840 count 7 log"),
            (std::vector<double>{60, 120, 240, 480, 960, 1920, 3840}));
  EXPECT_EQ(
      values("1e-6 .. 1e6 count 13 log"),
      (std::vector<double>{1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1, 10, 100, 1e3, 1e4, 1e5, 1e6}));
  EXPECT_EQ(values("0.1 .. 0.7 count 7"), (std::vector<double>{.1, .2, .3, .4, .5, .6, .7}));
  EXPECT_EQ(values("0.7 .. 0.1 step -0.1"), (std::vector<double>{.7, .6, .5, .4, .3, .2, .1}));
  // What is not a short decimal stays as computed.
  EXPECT_EQ(values("1 .. 2 count 4"), (std::vector<double>{1, 1 + 1. / 3, 1 + 2. / 3, 2}));
  EXPECT_EQ(values("pi / 2 .. 2 * pi step pi / 2")[1], std::numbers::pi);
}

TEST(Sweep, RangesCrossZeroAtZero) {
  const plan::Plan plan =
      PlanOf("let x = sweep(-0.3 .. 0.3 step 0.1)\nbenchmark b { world.side 10 + x }");
  EXPECT_EQ(std::get<double>(plan.axes.at(0).values.at(3)), 0);
}

TEST(Sweep, TheFirstWrittenVariesSlowest) {
  const plan::Plan plan =
      PlanOf("benchmark b { detector sweep(sap, dbvt); objects.quantity sweep(1, 2, 3) }");
  EXPECT_EQ(Axes(plan), "detector: sap dbvt; quantity: 1 2 3");
  ASSERT_EQ(plan.runs.size(), 6u);
  EXPECT_EQ(plan.runs[1].at, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(plan.runs[1].scene.groups[0].settings.Count("quantity"), 2u);
  EXPECT_EQ(plan.runs[3].scene.world.WordOr("detector"), "dbvt");
}

TEST(Sweep, AxesTakeTheNameOfWhatTheyMove) {
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects { aspect 1 : sweep(1, 2) : sweep(3, 4)\n"
                        "linear_velocity (0, 0, sweep(5, 6)); size normal(9, sweep(1, 2)) }\n"
                        "objects pebbles { size sweep(1, 2) as grain; mass sweep(1, 2) }\n"
                        "world.side 1000 * sweep(1, 2) }")),
            "aspect_y: 1 2; aspect_z: 3 4; linear_velocity_z: 5 6; size: 1 2; grain: 1 2; "
            "pebbles_mass: 1 2; side: 1000 2000");
}

TEST(Sweep, AxesHaveTitlesThatChangeNothingElse) {
  const auto plan_with = [](const std::string& as, const std::string& both) {
    return PlanOf("benchmark b { let n = sweep(10, 20)" + as + "\nobjects { quantity n }\n" +
                  "let x, y = zip(sweep(1, 2), sweep(3, 4)) as load" + both +
                  "\nworld.side 100 * x; objects.size y }");
  };
  const plan::Plan plain = plan_with("", "");
  const plan::Plan titled = plan_with(" as \"number of \\\"grains\\\"\"", " \"both\"");
  ASSERT_EQ(titled.axes.size(), 2u);
  EXPECT_EQ(titled.axes[0].name, "n");
  EXPECT_EQ(titled.axes[0].title, "number of \"grains\"");
  EXPECT_EQ(titled.axes[1].name, "load");
  EXPECT_EQ(titled.axes[1].title, "both");
  EXPECT_EQ(titled.Sha256(), plain.Sha256());
  EXPECT_EQ(titled.runs, plain.runs);
  EXPECT_EQ(yaml::FromYaml(yaml::ToYaml(titled), "p.yaml").axes, titled.axes);
  EXPECT_EQ(yaml::ToYaml(plain).find("title: \"both\""), std::string::npos);
  // In some cases only, and with a name of its own.
  const plan::Plan some = PlanOf(
      "benchmark b { cases { a { cycles sweep(1, 2) }\n"
      "b { cycles sweep(1, 2) as \"length\" } }\nwarmup sweep(0, 1) as w \"before\" }");
  ASSERT_EQ(some.axes.size(), 3u);
  EXPECT_EQ(some.axes[1].name + some.axes[1].title, "cycleslength");
  EXPECT_EQ(some.axes[2].name + some.axes[2].title, "wbefore");
}

TEST(Sweep, AnArgumentsAxisHasTheNameOfBoth) {
  const plan::Plan plan = PlanOf(
      "benchmark b { objects { location ring(radius: 10 * sweep(1, 2)) }\n"
      "objects rock { quantity 1; location at (0, sweep(5, 6), 0) }\n"
      "acceleration rotating((0, -9.8, sweep(0, 1)), (0, 0, 1), period: sweep(2, 4)) }");
  EXPECT_EQ(Axes(plan),
            "location_radius: 10 20; rock_location_y: 5 6; acceleration_vector_z: 0 1; "
            "acceleration_period: 2 4");
  const char* units[] = {"m", "m", "m/s^2", "s"};
  const char* parameters[] = {"objects.location", "rock.location", "acceleration", "acceleration"};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(plan.axes[i].unit, units[i]);
    EXPECT_EQ(plan.axes[i].parameter, parameters[i]);
  }
  ASSERT_EQ(plan.runs.size(), 16u);
  const plan::Scene& last = plan.runs.back().scene;
  EXPECT_EQ(schema::ToText(last.groups[0].settings.Get("location")), "ring(radius: 20)");
  EXPECT_EQ(schema::ToText(last.groups[1].settings.Get("location")), "at(0, 6, 0)");
  EXPECT_EQ(schema::ToText(last.world.Get("acceleration")), "rotating((0, -9.8, 1), (0, 0, 1), 4)");
}

TEST(Points, CountTheObjects) {
  const plan::Plan plan = PlanOf(
      "let high = (0, 9, 0)\n"
      "benchmark b { objects { location sweep(at((0, 0, 0), high, 2 * high), at(high), at(1, 2, "
      "3)) }\n"
      "objects rest { quantity 5 } }");
  EXPECT_EQ(Axes(plan), "location: at((0, 0, 0), (0, 9, 0), (0, 18, 0)) at((0, 9, 0)) at(1, 2, 3)");
  ASSERT_EQ(plan.runs.size(), 3u);
  const std::uint64_t counts[] = {3, 1, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(plan.runs[i].scene.groups[0].settings.Count("quantity"), counts[i]);
    // 50 m for each object of all groups.
    EXPECT_EQ(plan.runs[i].scene.world.Real("world.side"), 50 * static_cast<double>(counts[i] + 5));
  }
}

TEST(Points, CountOnlyWhereTheyAreListed) {
  // Another layout may use the quantity itself.
  const plan::Plan plan = PlanOf(
      "let where = at((0, 0, 0), (9, 0, 0))\n"
      "benchmark b { objects { location sweep(ring(radius: quantity), where) } }");
  EXPECT_EQ(schema::ToText(plan.runs[0].scene.groups[0].settings.Get("location")),
            "ring(radius: 10)");
  EXPECT_EQ(plan.runs[1].scene.groups[0].settings.Count("quantity"), 2u);
}

TEST(Points, AnAxisInAPointIsOfItsComponent) {
  const plan::Plan plan =
      PlanOf("benchmark b { objects { location at((0, sweep(1, 2), 0), (5, 0, 0)) } }");
  EXPECT_EQ(Axes(plan), "location_y: 1 2");
  EXPECT_EQ(plan.axes[0].unit, "m");
  EXPECT_EQ(schema::ToText(plan.runs[1].scene.groups[0].settings.Get("location")),
            "at((0, 2, 0), (5, 0, 0))");
}

TEST(Sweep, AnArgumentsAxisInALetOrUnderAName) {
  EXPECT_EQ(Axes(PlanOf("let near = pair(distance: sweep(1, 2))\n"
                        "benchmark b { objects { quantity 2; location near } }")),
            "near_distance: 1 2");
  EXPECT_EQ(Axes(PlanOf("let r = sweep(1, 2)\n"
                        "benchmark b { objects.location ring radius: r * 2 }")),
            "r: 1 2");
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects.location ring radius: sweep(1, 2) as wide }")),
            "wide: 1 2");
  // In an argument, where `ring` is not a word, it refers to the let.
  const plan::Plan plan =
      PlanOf("let ring = sweep(1, 2)\nbenchmark b { objects.location ring(ring) }");
  EXPECT_EQ(Axes(plan), "ring: 1 2");
  EXPECT_EQ(schema::ToText(plan.runs[1].scene.groups[0].settings.Get("location")),
            "ring(radius: 2)");
}

TEST(Sweep, WordsWithArgumentsMayBeValues) {
  const plan::Plan plan = PlanOf(
      "benchmark b { objects.location sweep(uniform, grid, ring radius: 3, ring(2 * 2))\n"
      "skip when objects.location == grid or location == ring(radius: 4) }");
  EXPECT_EQ(Axes(plan), "location: uniform grid ring(radius: 3) ring(radius: 4)");
  EXPECT_EQ(plan.skipped, (std::vector<std::vector<std::size_t>>{{1}, {3}}));
  EXPECT_EQ(plan.runs[0].scene.groups[0].settings.Get("location"),
            schema::Value(schema::Word{"uniform"}));
}

TEST(Word, HasAllArgumentsInTheOrderOfItsRow) {
  const auto location = [](const std::string& text) {
    return PlanOf("benchmark b { objects.location " + text + " }")
        .runs.at(0)
        .scene.groups[0]
        .settings.Get("location");
  };
  const schema::Value fit = schema::Word{"fit"}, all = schema::Word{"all"};
  EXPECT_EQ(location("grid"), schema::Value(schema::Call{"grid", {fit}}));
  EXPECT_EQ(location("grid()"), schema::Value(schema::Call{"grid", {fit}}));
  EXPECT_EQ(location("grid spacing: 3"), schema::Value(schema::Call{"grid", {3.0}}));
  EXPECT_EQ(location("stack"), schema::Value(schema::Call{"stack", {all, fit, fit}}));
  EXPECT_EQ(location("stack(spacing: 4, height: 2)"),
            schema::Value(schema::Call{"stack", {std::uint64_t{2}, fit, 4.0}}));
  EXPECT_EQ(location("stack(2, fit, spacing: 4)"), location("stack(spacing: 4, height: 2)"));
  EXPECT_EQ(location("ring radius: quantity / 4"), schema::Value(schema::Call{"ring", {2.5}}));
}

TEST(Word, MeansTheSameInALetOrAnyScope) {
  const auto id = [](const std::string& text) { return PlanOf(text).runs.at(0).id; };
  const std::string direct = id("benchmark b { objects.location grid }");
  EXPECT_EQ(direct, id("let where = grid\nbenchmark b { objects.location where }"));
  EXPECT_EQ(direct, id("let where = grid(spacing: fit)\nbenchmark b { objects.location where }"));
  // A let may have the name of such a word: after `location` it is the word.
  EXPECT_EQ(direct, id("let grid = 3\nbenchmark b { objects.location grid }"));
}

constexpr const char* kRock = "v 0 0 0";

TEST(Model, IsNamedFromTheFileThatSaysItAndByItsBytes) {
  const plan::Plan plan = PlanOf(
      "use \"parts/stones\"\n"
      "benchmark b { objects { type any(stone, sphere, hull file: \"./parts/../rock.OBJ\" 2) } }",
      {{"parts/stones.cdb", "let stone = mesh(\"rock.obj\")"},
       {"parts/rock.obj", kRock},
       {"rock.OBJ", "v 1 1 1"}});
  const auto& type =
      std::get<schema::Distribution>(plan.runs.at(0).scene.groups[0].settings.Get("type"));
  const schema::Value hash = schema::Text{plan::Sha256Hex(kRock)};
  EXPECT_EQ(type.arguments[0],
            Layout("mesh", {{"file", schema::Text{"parts/rock.obj"}}, {"sha256", hash}}));
  EXPECT_EQ(type.arguments[2],
            Layout("hull", {{"file", schema::Text{"rock.OBJ"}},
                            {"sha256", schema::Text{plan::Sha256Hex("v 1 1 1")}}}));
  EXPECT_EQ(type.weights, (std::vector<double>{1, 1, 2}));
}

TEST(Model, MayBeSweptAndItsHashGiven) {
  const std::map<std::string, std::string> files = {{"a.obj", kRock}, {"b.obj", "v 1 1 1"}};
  const plan::Plan plan =
      PlanOf("benchmark b { objects.type mesh(sweep(\"a.obj\", \"b.obj\")) }", files);
  EXPECT_EQ(Axes(plan), "type_file: a.obj b.obj");
  EXPECT_NE(plan.runs[0].id, plan.runs[1].id);
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects.type sweep(sphere, mesh(\"a.obj\")) }", files)),
            "type: sphere mesh(\"a.obj\")");
  const std::string given =
      "benchmark b { objects.type mesh(\"a.obj\", sha256: \"" + plan::Sha256Hex(kRock) + "\") }";
  EXPECT_EQ(PlanOf(given, files).runs[0].id, plan.runs[0].id);
}

TEST(Model, IsReadOnce) {
  int reads = 0;
  const compiler::Compilation result = compiler::Compile(
      "a/b.cdb", [&](const std::string& path, std::string&) -> std::optional<std::string> {
        if (path == "a/b.cdb")
          return "benchmark b { objects { type mesh(\"r.obj\"); mass sweep(1, 2) }\n"
                 "objects c { type hull(\"x/../r.obj\") } }";
        EXPECT_EQ(path, "a/r.obj");
        ++reads;
        return kRock;
      });
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  EXPECT_EQ(reads, 1);
}

TEST(Sweep, ALetIsOneAxisWhereverItIsUsed) {
  const plan::Plan plan = PlanOf(
      "let n = sweep(10, 20)\nbenchmark b { objects.quantity n; world.side 20 * n; objects.mass n "
      "/ 4 }");
  EXPECT_EQ(Axes(plan), "n: 10 20");
  ASSERT_EQ(plan.runs.size(), 2u);
  EXPECT_EQ(plan.runs[1].scene.world.Real("world.side"), 400);
  EXPECT_EQ(plan.runs[1].scene.groups[0].settings.Real("mass"), 5);
}

TEST(Sweep, DistributionsAndVectorsMayBeValues) {
  const plan::Plan plan = PlanOf(
      "benchmark b { objects { linear_velocity sweep((0, 0, 0), (1, 2, 3)); size sweep(5, "
      "uniform(1, 9))\n"
      "type any(sphere, sweep(cone, cuboid)) } }");
  EXPECT_EQ(Axes(plan),
            "linear_velocity: (0, 0, 0) (1, 2, 3); size: 5 uniform(1, 9); type: cone cuboid");
  EXPECT_EQ(schema::ToText(plan.runs.back().scene.groups[0].settings.Get("type")),
            "any(sphere, cuboid)");
}

TEST(Sweep, SeedsOf64BitsStayExact) {
  const plan::Plan plan = PlanOf("benchmark b { seed sweep(1, 0xFFFFFFFFFFFFFFFF) }");
  EXPECT_EQ(Axes(plan), "seed: 1 18446744073709551615");
  EXPECT_EQ(plan.runs[1].scene.world.Count("seed"), 0xFFFFFFFFFFFFFFFFu);
}

TEST(Value, ParametersMayBeUsedLikeLets) {
  const plan::Plan plan =
      PlanOf("benchmark b { objects { quantity 3 } world.side 7 * quantity }\n");
  EXPECT_EQ(plan.runs[0].scene.world.Real("world.side"), 21);
}

TEST(Value, TheCubeGrowsWithAllObjects) {
  const plan::Plan plan =
      PlanOf("benchmark b { objects { quantity 3 } objects more { quantity 4 } }");
  EXPECT_EQ(plan.runs[0].scene.world.Real("world.side"), 350);
  EXPECT_EQ(PlanOf("benchmark b { objects.quantity 0 }").runs[0].scene.world.Real("world.side"),
            50);
}

TEST(Base, LaysItsOwnOver) {
  const plan::Plan plan = PlanOf(
      "benchmark a { cycles sweep(1, 2); let s = 4; objects { size s; mass 2 } }\n"
      "benchmark b from a { objects.mass 3; cycles sweep(7, 8); let s = 5; detector sap }",
      {}, 1);
  EXPECT_EQ(Axes(plan), "cycles: 7 8");
  const plan::GroupSettings& objects = plan.runs[0].scene.groups[0].settings;
  EXPECT_EQ(objects.Real("mass"), 3);
  EXPECT_EQ(objects.Real("size"), 5);
}

TEST(Cases, AreAnAxisAndMaySweep) {
  const plan::Plan plan = PlanOf(
      "benchmark b { objects.size 20; cases load { calm { } storm { objects.size sweep(10, 20) } } "
      "}");
  EXPECT_EQ(Axes(plan), "load: calm storm; size: 20 10");
  EXPECT_EQ(plan.runs.size(), 3u);
  EXPECT_EQ(plan.skipped, (std::vector<std::vector<std::size_t>>{{0, 1}}));
}

TEST(Cases, WithoutAValueForAnAxisHaveNone) {
  const plan::Plan plan =
      PlanOf("benchmark b { cases { a { } b { objects grit { quantity sweep(1, 2) } } } }");
  EXPECT_EQ(Axes(plan), "case: a b; grit_quantity: none 1 2");
  EXPECT_EQ(plan.runs.size(), 3u);
  EXPECT_EQ(plan.runs[0].scene.groups.size(), 1u);
  EXPECT_EQ(plan.runs[1].scene.groups.size(), 1u);
  EXPECT_EQ(plan.runs[1].scene.groups[0].name, "grit");
}

TEST(Cases, TwoAreTheirProduct) {
  const plan::Plan plan = PlanOf(
      "benchmark b { cases x { a { cycles 1 } b { cycles 2 } } cases y { c { } d { objects.size 1 "
      "} } }");
  EXPECT_EQ(Axes(plan), "x: a b; y: c d");
  EXPECT_EQ(plan.runs[3].scene.world.Count("cycles"), 2u);
  EXPECT_EQ(plan.runs[3].scene.groups[0].settings.Real("size"), 1);
  EXPECT_EQ(plan.runs[2].scene.groups[0].settings.Real("size"), 50);
}

TEST(Cases, AnArgumentThatIsNotSweptHasItsValue) {
  EXPECT_EQ(Axes(PlanOf("benchmark b { cases { a { objects.location ring(radius: 2) }\n"
                        "b { objects.location ring(radius: sweep(1, 2)) }\n"
                        "c { objects.location ring } d { } } }")),
            "case: a b c d; location_radius: 2 1 fit none");
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects.quantity 1; cases {\n"
                        "a { objects.linear_velocity rotating((1, 2, 3), (0, 0, 1), 4) }\n"
                        "b { objects.linear_velocity rotating((1, sweep(2, 5), 3), (0, 0, 1), 4) }"
                        "} }")),
            "case: a b; linear_velocity_vector_y: 2 5");
}

TEST(Skip, LeavesPointsOut) {
  const plan::Plan plan = PlanOf(
      "let big = 2\nbenchmark b { objects.quantity sweep(1, 2, 3); detector sweep(simple, dbvt)\n"
      "skip when quantity > big and detector == simple or not (quantity >= 2) }");
  EXPECT_EQ(plan.skipped, (std::vector<std::vector<std::size_t>>{{0, 0}, {0, 1}, {2, 0}}));
  EXPECT_EQ(plan.runs.size(), 3u);
}

TEST(Skip, OnlyLeavesOutTheOthers) {
  const std::string grid =
      "benchmark b { objects.quantity sweep(1, 2, 3); detector sweep(simple, sap, dbvt)\n";
  EXPECT_EQ(PlanOf(grid + "only when quantity > 1 and detector in (sap, dbvt) }").runs.size(), 4u);
  EXPECT_EQ(PlanOf(grid + "only when quantity > 1; only when detector == sap }").runs.size(), 2u);
  EXPECT_EQ(PlanOf(grid + "skip when detector not in (sap) }").skipped,
            PlanOf(grid + "only when detector == sap }").skipped);
}

TEST(Zip, MovesSweepsTogether) {
  const std::string uses =
      "benchmark b { objects.quantity n; world.side s; detector sweep(sap, dbvt) }";
  const plan::Plan plan =
      PlanOf("let n, s = zip(sweep(1, 2, 3), sweep(100 .. 300 step 100))\n" + uses);
  EXPECT_EQ(Axes(plan), "n: 1 2 3; detector: sap dbvt");
  ASSERT_EQ(plan.runs.size(), 6u);
  EXPECT_EQ(plan.runs[5].scene.ObjectCount(), 3u);
  EXPECT_EQ(plan.runs[5].scene.world.Real("world.side"), 300);
  EXPECT_EQ(Axes(PlanOf("let n, s = zip(sweep(1, 2), sweep(100, 200)) as load\n" + uses)),
            "load: 1 2; detector: sap dbvt");
  // Only the second is used, in a condition too.
  const plan::Plan second = PlanOf(
      "let n, s = zip(sweep(1, 2), sweep(100, 200))\n"
      "benchmark b { world.side s; skip when s == 100 }");
  EXPECT_EQ(Axes(second), "n: 1 2");
  ASSERT_EQ(second.runs.size(), 1u);
  EXPECT_EQ(second.runs[0].scene.world.Real("world.side"), 200);
  // If the first sweep repeats a value, the axis shows both.
  EXPECT_EQ(PlanOf("let n, s = zip(sweep(1, 1), sweep(100, 200))\n" + uses).axes[0].values,
            (std::vector<plan::Coordinate>{"1, 100", "1, 200"}));
  const compiler::Compilation uneven =
      CompileText("let n, s = zip(sweep(1, 2, 3), sweep(100, 200))\n" + uses);
  ASSERT_EQ(uneven.diagnostics.error_count(), 1);
  EXPECT_EQ(uneven.diagnostics.all()[0].message, "the sweeps of zip() have 3 and 2 values");
}

TEST(Sweep, LogarithmicRangesOfCountsAreWhole) {
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects.quantity sweep(10 .. 5000 count 6 log) }")),
            "quantity: 10 35 120 416 1443 5000");
  // Rounded values that are equal are merged.
  EXPECT_EQ(Axes(PlanOf("benchmark b { cycles sweep(1 .. 8 count 7 log) }")),
            "cycles: 1 2 3 4 6 8");
  EXPECT_EQ(Axes(PlanOf("let r = 1 .. 10 count 3 log\n"
                        "benchmark b { cycles sweep(r); timestep sweep(r) }")),
            "cycles: 1 3 10; timestep: 1 3.1622776601683795 10");
}

TEST(Skip, SavesAPointThatCouldNotBeRun) {
  const plan::Plan plan = PlanOf(
      "benchmark b { objects.quantity sweep(10, 20000); detector sweep(sap, dbvt)\n"
      "skip when quantity > 16378 and detector == sap }");
  EXPECT_EQ(plan.runs.size(), 3u);
}

TEST(Use, BringsLetsAndBenchmarks) {
  const std::string used = "let side = 123\nbenchmark base { world.side side; cycles 3 }";
  const plan::Plan plan = PlanOf("use \"base\"\nbenchmark b from base { objects.size side / 10 }",
                                 {{"base.cdb", used}});
  EXPECT_EQ(plan.runs[0].scene.world.Real("world.side"), 123);
  EXPECT_EQ(plan.runs[0].scene.groups[0].settings.Real("size"), 12.3);
  EXPECT_EQ(PlanOf("use \"x/y\"\nbenchmark b from base { }", {{"lib/x/y.cdb", used}}).runs.size(),
            1u);
  EXPECT_EQ(CompileText("use \"base\"\nbenchmark b { }", {{"base.cdb", used}}).plans.size(), 1u)
      << "a used file's own benchmarks are not run";
}

TEST(Omit, IsAnAxisOfWordsLikeAnyOther) {
  const plan::Plan plan = PlanOf("benchmark b { detector sap; omit sweep(none, auto, sleeping) }");
  EXPECT_EQ(Axes(plan), "omit: none auto sleeping");
  EXPECT_EQ(plan.axes[0].parameter, "omit");
  ASSERT_EQ(plan.runs.size(), 3u);
  const char* words[] = {"none", "auto", "sleeping"};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(plan.runs[i].scene.world.Get("omit"), schema::Value(schema::WordList{words[i]})) << i;
  EXPECT_EQ(Axes(PlanOf("let mode = sweep(none, auto)\nbenchmark b { omit mode }")),
            "mode: none auto");
  const plan::Plan lists =
      PlanOf("let part = walls\nbenchmark b { omit sweep(pools, solver), part }");
  EXPECT_EQ(Axes(lists), "omit: pools solver");
  EXPECT_EQ(lists.runs[1].scene.world.Get("omit"),
            schema::Value(schema::WordList{"solver", "walls"}));
}

// `sleeping` is both a component and a switch.
TEST(Omit, ItsWordsComeBeforeTheNamesOfParameters) {
  const plan::Plan plan =
      PlanOf("benchmark b { sleeping off; omit sleeping, walls; skip when omit == sleeping }");
  EXPECT_EQ(plan.runs[0].scene.world.Get("omit"),
            schema::Value(schema::WordList{"sleeping", "walls"}));
  EXPECT_EQ(
      PlanOf("benchmark b { omit sweep(sleeping, none); skip when omit == sleeping }").skipped,
      (std::vector<std::vector<std::size_t>>{{0}}));
  EXPECT_EQ(PlanOf("benchmark b { sleeping sweep(on, off); omit sweep(sleeping, none)\n"
                   "skip when sleeping == off and omit != sleeping }")
                .skipped,
            (std::vector<std::vector<std::size_t>>{{1, 1}}));
}

TEST(Omit, ALetMayHaveTheNameOfAComponent) {
  const plan::Plan plan = PlanOf(
      "let gravity = sweep(0, 9.8)\n"
      "benchmark b { acceleration (0, -gravity, 0); omit walls, rotation }");
  EXPECT_EQ(Axes(plan), "gravity: 0 9.8");
  EXPECT_EQ(Axes(PlanOf("let walls = sweep(1, 2)\n"
                        "benchmark b { cycles walls; omit walls }")),
            "walls: 1 2");
}
TEST(Omit, AListIsOneValueOfAnAxisOfCases) {
  const plan::Plan plan = PlanOf(
      "benchmark b { cases { a { omit sweep(none, auto) } b { omit walls, pools } c { } }\n"
      "skip when omit == none }");
  EXPECT_EQ(Axes(plan), "case: a b c; omit: none auto pools, walls");
  EXPECT_EQ(plan.runs.size(), 3u);
  EXPECT_EQ(plan.runs[1].at, (std::vector<std::size_t>{1, 2}));
}

// A component that no run needs may be listed, even if a skipped run would need it.
TEST(Omit, ASkippedPointMayNeedIt) {
  const std::string text =
      "benchmark b { acceleration sweep((0, 0, 0), (0, -9, 0)); omit sweep(none, gravity)\n";
  EXPECT_FALSE(CompileText(text + "}").plans.size() == 1);
  EXPECT_EQ(PlanOf(text + "skip when omit == gravity and acceleration != (0, 0, 0) }").runs.size(),
            3u);
}

TEST(Seeds, EveryDistributionHasAStreamOfItsOwn) {
  const plan::Plan plan = PlanOf(
      "benchmark b { objects { size uniform(1, 2); mass uniform(1, 2) } objects p { size "
      "uniform(1, 2) }\n"
      "acceleration normal(0, 1) }");
  const plan::Scene& scene = plan.runs[0].scene;
  std::string streams;
  for (const auto& [stream, seed] : scene.seeds) {
    streams += stream + " ";
    EXPECT_EQ(seed, plan::StreamSeed(0xAAAAAAAAAA, stream));
  }
  EXPECT_EQ(streams, "acceleration objects.location objects.mass objects.size p.location p.size ");
}

TEST(Seeds, AScheduleThatDrawsHasOne) {
  const plan::Plan plan = PlanOf(
      "benchmark b { acceleration every(60, uniform((-1, -1, -1), (1, 1, 1)))\n"
      "objects { linear_velocity every(60, (1, 0, 0))\n"
      "angular_velocity every(60, any(0, (1, 0, 0))) } }");
  std::string streams;
  for (const auto& [stream, seed] : plan.runs[0].scene.seeds) streams += stream + " ";
  EXPECT_EQ(streams, "acceleration objects.angular_velocity objects.location ");
}

TEST(Run, IsNamedByAllThatDecidesItsResult) {
  const plan::Run a = PlanOf("benchmark a { cycles 5; objects.size 50 }").runs[0];
  const plan::Run b =
      PlanOf("let five = 5\nbenchmark other \"title\" { objects.quantity 10; cycles five }")
          .runs[0];
  const plan::Run c = PlanOf("benchmark a { cycles 5; objects.size 51 }").runs[0];
  EXPECT_EQ(a.id, b.id);
  EXPECT_NE(a.id, c.id);
  const plan::Plan repeated = PlanOf("benchmark a { repeats 2 }");
  EXPECT_NE(repeated.runs[0].id, repeated.runs[1].id);
}

TEST(Run, OrderOfAListHasNoMeaning) {
  EXPECT_EQ(PlanOf("benchmark a { record timing, counts }").runs[0].id,
            PlanOf("benchmark a { record counts, timing }").runs[0].id);
  EXPECT_EQ(PlanOf("benchmark a { omit walls, pools }").runs[0].id,
            PlanOf("benchmark a { omit pools, walls }").runs[0].id);
}

TEST(Blocks, StandInBlocks) {
  const plan::Plan plan = PlanOf(
      "benchmark b {\n"
      "  let k = 3; objects.links.stiffness 1\n"
      "  objects pebbles {\n"
      "    let m = 2; quantity 4\n"
      "    links { let s = m * k; type ball; stiffness s * sweep(1, 2); damping stiffness + "
      "quantity }\n"
      "  }\n"
      "  pebbles.links.anchor off; objects { links.end_mass 7 }\n"
      "}");
  EXPECT_EQ(Axes(plan), "pebbles_links_stiffness: 6 12");
  EXPECT_EQ(plan.axes[0].parameter, "pebbles.links.stiffness");
  EXPECT_EQ(plan.axes[0].unit, "N/m");
  ASSERT_EQ(plan.runs.size(), 2u);
  const std::vector<plan::Group>& groups = plan.runs[1].scene.groups;
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].settings.Real("links.stiffness"), 1);
  EXPECT_EQ(groups[0].settings.Real("links.end_mass"), 7);
  EXPECT_FALSE(groups[0].HasLinks());
  EXPECT_EQ(groups[1].settings.Real("links.stiffness"), 12);
  EXPECT_EQ(groups[1].settings.Real("links.damping"), 16) << "names are looked for outwards";
  EXPECT_FALSE(groups[1].settings.On("links.anchor"));
  EXPECT_TRUE(groups[1].HasLinks());
}

TEST(Blocks, NameTheirAxes) {
  EXPECT_EQ(Axes(PlanOf("benchmark b { objects { links { type sweep(none, ball) } } }")),
            "links_type: none ball");
  EXPECT_EQ(Axes(PlanOf("benchmark b { world { side sweep(100, 200) } }")), "side: 100 200");
}

// The language reference promises that `benchmark b { }` is a complete benchmark, and that its
// first example has 75 runs.
TEST(Language, FirstExample) {
  const plan::Plan plan = PlanOf(
      "benchmark aspect \"figure 4\" {\n  objects {\n    quantity  sweep(1000 .. 5000 step 1000)\n"
      "    type      any(sphere, cuboid, cylinder, cone)\n    aspect    1 : 1 : sweep(1 .. 5)\n  "
      "}\n"
      "  detector    sweep(simple, sap, dbvt)\n}\n");
  EXPECT_EQ(plan.runs.size(), 75u);
  EXPECT_EQ(Axes(plan),
            "quantity: 1000 2000 3000 4000 5000; aspect_z: 1 2 3 4 5; detector: simple sap dbvt");
}

}  // namespace
}  // namespace cdb::tests
