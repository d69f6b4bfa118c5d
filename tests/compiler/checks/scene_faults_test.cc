// Faults of scenes are reported once each, with their runs.
#include "compiler/checks/scene_faults.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "compiler/scenario/diagnostic_kinds.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

/// Compiles `text`, with `find` in place of the library's search for faults.
compiler::Compilation CompileWith(const std::string& text, analysis::FindSceneFault find) {
  const auto read = [&](const std::string&, std::string&) { return std::optional(text); };
  compiler::CompileOptions options;
  options.find_fault = std::move(find);
  options.read_model = MadeUpModels;
  return compiler::Compile("test.cdb", read, options);
}

/// Finds a fault in scenes with more than `most` objects.
analysis::FindSceneFault TooMany(std::uint64_t most, analysis::SceneFault::Kind kind) {
  return [=](const plan::Scene& scene, std::uint64_t&) -> std::optional<analysis::SceneFault> {
    if (scene.ObjectCount() <= most) return std::nullopt;
    return analysis::SceneFault{kind, "objects", "it is full", "take some out"};
  };
}

TEST(SceneFaults, OfSomeRunsAreAWarningAndOfAllAnError) {
  const std::string text =
      "benchmark b { objects { size 1; quantity sweep(1, 20, 30) }; detector sweep(dbvt, sap) }";
  const auto some = CompileWith(text, TooMany(10, analysis::SceneFault::Kind::kPlacement));
  ASSERT_EQ(some.diagnostics.all().size(), 1u);
  EXPECT_EQ(some.diagnostics.all()[0].kind, &scenario::kRunsWillFail);
  EXPECT_EQ(some.diagnostics.all()[0].message, "runs will fail: it is full; in 4 of 6 runs");
  EXPECT_EQ(some.diagnostics.all()[0].help, "take some out");
  EXPECT_EQ(some.plans.size(), 1u);
  const auto all = CompileWith(text, TooMany(0, analysis::SceneFault::Kind::kPlacement));
  ASSERT_EQ(all.diagnostics.all().size(), 1u);
  EXPECT_EQ(all.diagnostics.all()[0].kind, &scenario::kCannotPlace);
  EXPECT_TRUE(all.plans.empty());
  EXPECT_TRUE(CompileWith(text, {}).diagnostics.all().empty());
}

TEST(SceneFaults, OfAClosedFormAreErrorsInAnyRun) {
  const auto result = CompileWith(
      "benchmark b { objects.quantity sweep(1, 20)\n"
      "accuracy { metrics position; closed_form flight } }",
      TooMany(10, analysis::SceneFault::Kind::kClosedForm));
  ASSERT_TRUE(result.diagnostics.has_errors());
  EXPECT_EQ(result.diagnostics.all()[0].kind, &scenario::kWrongForm);
  EXPECT_EQ(result.diagnostics.all()[0].message, "it is full; in 1 of 2 runs");
}

TEST(SceneFaults, AreLookedForOnceInScenesThatPlaceTheSame) {
  int looks = 0;
  const analysis::FindSceneFault count = [&](const plan::Scene&, std::uint64_t&) {
    ++looks;
    return std::nullopt;
  };
  CompileWith("benchmark b { timestep sweep(1 / 60, 1 / 120); detector sweep(dbvt, sap) }", count);
  EXPECT_EQ(looks, 1);
  looks = 0;
  CompileWith("benchmark b { world.side sweep(500, 600); objects.size sweep(1, 2) }", count);
  EXPECT_EQ(looks, 4);
  // The number of objects examined is limited as well.
  looks = 0;
  CompileWith("benchmark b { objects { quantity 300000; size sweep(1 .. 9) }; detector dbvt }",
              count);
  EXPECT_EQ(looks, 3);
  looks = 0;
  CompileWith(
      "benchmark b { objects { quantity 10000; size sweep(1 .. 9) }; detector dbvt\n"
      "accuracy { metrics position; closed_form flight } }",
      count);
  EXPECT_EQ(looks, 4);
}

TEST(SceneFaults, OfADefaultSizeSaySo) {
  const analysis::FindSceneFault nothing = [](const plan::Scene&, std::uint64_t&) {
    return std::nullopt;
  };
  const auto warnings = [&](const std::string& groups) {
    const auto result = CompileWith("benchmark b { world.side 500\n" + groups + " }", nothing);
    int count = 0;
    for (const dsl::Diagnostic& diagnostic : result.diagnostics.all())
      count += diagnostic.kind == &scenario::kDefaultSize;
    return count;
  };
  EXPECT_EQ(warnings("objects a { size 0.2 }\nobjects b { }"), 1);
  EXPECT_EQ(warnings("objects a { size sweep(0.1, 5) }\nobjects b { }\nobjects c { }"), 2);
  EXPECT_EQ(warnings("objects a { size 6 }\nobjects b { }"), 0);
  EXPECT_EQ(warnings("objects a { size 0.2 }\nobjects b { size 50 }"), 0);
  EXPECT_EQ(warnings("objects a { size 0.2 }\nobjects b { quantity 0 }"), 0);
  EXPECT_EQ(warnings("objects b { }"), 0);
}

/// The warnings of a kind.
std::vector<std::string> WarningsOf(const dsl::DiagnosticKind& kind,
                                    const std::string& statements) {
  const auto result =
      CompileWith("benchmark b { detector dbvt; world.side 500\n" + statements + " }",
                  [](const plan::Scene&, std::uint64_t&) { return std::nullopt; });
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  std::vector<std::string> messages;
  for (const dsl::Diagnostic& diagnostic : result.diagnostics.all())
    if (diagnostic.kind == &kind) messages.push_back(diagnostic.message);
  return messages;
}

TEST(SceneFaults, LimitsInDegreesAreWarnedOf) {
  const auto warnings = [](const std::string& limits, const std::string& type = "hinge") {
    return WarningsOf(scenario::kLargeAngle,
                      "objects a { quantity 1 }\nobjects b { quantity 1; location at(300, 0, 0) }\n"
                      "joints j { parent a; child b; type " +
                          type + "; at (0, 0, 0); limits { " + limits + " } }")
        .size();
  };
  EXPECT_EQ(warnings("lower -90; upper 90"), 1);
  EXPECT_EQ(warnings("lower 0; upper 170"), 1);
  EXPECT_EQ(warnings("lower -360; upper 360"), 1);
  EXPECT_EQ(warnings("lower -90 deg; upper 90 deg"), 0);
  EXPECT_EQ(warnings("lower -3; upper 3"), 0);
  EXPECT_EQ(warnings("lower -20; upper 20"), 0) << "three turns";
  EXPECT_EQ(warnings("lower -62.8; upper 62.8"), 0) << "ten turns";
  EXPECT_EQ(warnings("lower -10000; upper 10000"), 0) << "no limits";
  EXPECT_EQ(warnings("lower -90; upper 90", "slider"), 0);
}

TEST(SceneFaults, InertiasOfOtherUnitsAreWarnedOfOnce) {
  // A diagonal of 2.29 m: the moments of the box add up to 0.875 m^2.
  const auto group = [](const std::string& name, double moment) {
    return fmt::format(
        "objects {} {{ quantity 1; size native; location at(0, 0, 0); type compound(part(cuboid, "
        "(2, 1, 0.5)), inertia: ({}, {}, {})) }}\n",
        name, moment, moment, moment);
  };
  const auto warnings = [](const std::string& groups) {
    return WarningsOf(scenario::kOddInertia, groups);
  };
  EXPECT_TRUE(warnings(group("a", 0.29)).empty());
  EXPECT_TRUE(warnings(group("a", 20)).empty()) << "eight times as large: all mass far outside";
  EXPECT_TRUE(warnings(group("a", 0.01)).empty()) << "all mass in the middle";
  const auto large = warnings(group("a", 290) + group("b", 0.29) + group("c", 2e-4));
  ASSERT_EQ(large.size(), 1);
  EXPECT_EQ(large[0],
            "the inertia of `a` is that of a body 72 m across, but its parts are 2.3 m; so are "
            "those of c");
}

}  // namespace
}  // namespace cdb::tests
