// Units: values in SI, and dimensions that do not fit.
#include "compiler/evaluate/dimensions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using schema::Number;

Number ConvertedLiteral(const char* literal, const char* unit) {
  return evaluate::InSi(*Number::FromLiteral(literal), *text::ParseUnit(unit));
}

TEST(Units, DecimalsAreTheSameDoubleAsWrittenInSi) {
  EXPECT_EQ(ConvertedLiteral("10", "ms").AsReal(), 0.01);
  EXPECT_EQ(ConvertedLiteral("0.1", "ms").AsReal(), 0.0001);
  EXPECT_EQ(ConvertedLiteral("16.6667", "ms").AsReal(), 0.0166667);
  EXPECT_EQ(ConvertedLiteral("0.1", "min").AsReal(), 6.0);
  EXPECT_EQ(ConvertedLiteral("2.54", "cm").AsReal(), 0.0254);
  EXPECT_EQ(ConvertedLiteral("7.3", "g").AsReal(), 0.0073);
  EXPECT_EQ(ConvertedLiteral("1e-3", "km").AsReal(), 1.0);
  EXPECT_EQ(ConvertedLiteral("2.7", "g/cm^3").AsReal(), 2700.0);
  EXPECT_EQ(ConvertedLiteral("36", "km/h").AsReal(), 10.0);
  EXPECT_EQ(ConvertedLiteral("1.5", "kN").AsReal(), 1500.0);
  EXPECT_EQ(ConvertedLiteral("1.5", "GB").AsReal(), 1.5e9);
}

// A factor in binary would round twice: 0.3 / 1000 and 0.0003 differ.
TEST(Units, EveryThousandthIsTheNearestDouble) {
  int different = 0;
  for (int i = 1; i < 2000; ++i) {
    const std::string text = std::to_string(i);
    const double nearest = std::stod("0.000" + std::string(4 - text.size(), '0') + text);
    EXPECT_EQ(evaluate::InSi(std::stod(text + "e-4"), *text::ParseUnit("ms")).AsReal(), nearest)
        << i;
    different += std::stod(text + "e-4") * 1e-3 != nearest;
  }
  EXPECT_GT(different, 100);
}

TEST(Units, WholeNumbersStayWholeWhereTheyAre) {
  EXPECT_EQ(ConvertedLiteral("5", "km"), Number::Whole(5000));
  EXPECT_EQ(ConvertedLiteral("5", "min"), Number::Whole(300));
  EXPECT_EQ(ConvertedLiteral("5000", "mm"), Number::Whole(5));
  EXPECT_EQ(ConvertedLiteral("500", "MiB"), Number::Whole(524288000));
  EXPECT_EQ(ConvertedLiteral("2", "TiB"), Number::Whole(2199023255552));
  EXPECT_FALSE(ConvertedLiteral("5", "mm").is_whole());
}

TEST(Units, AnglesAreTheNearestDoubles) {
  const double pi = 3.14159265358979323846;
  for (const int part : {1, 2, 3, 4, 6, 9, 10, 12, 18, 36, 180}) {
    const double exact = static_cast<double>(3.14159265358979323846264338328L / part);
    EXPECT_DOUBLE_EQ(ConvertedLiteral(std::to_string(180 / part).c_str(), "deg").AsReal(), exact);
  }
  EXPECT_EQ(ConvertedLiteral("180", "deg").AsReal(), pi);
  EXPECT_EQ(ConvertedLiteral("90", "deg/s").AsReal(), pi / 2);
  EXPECT_EQ(ConvertedLiteral("30", "rpm").AsReal(), pi);
}

TEST(Units, ExtremesAreInfiniteOrZeroAndNeverUndefined) {
  EXPECT_EQ(ConvertedLiteral("1e308", "km").AsReal(), INFINITY);
  EXPECT_EQ(ConvertedLiteral("5e-324", "mm").AsReal(), 0);
  EXPECT_DOUBLE_EQ(ConvertedLiteral("18446744073709551615", "h^9").AsReal(),
                   18446744073709551615.0 * std::pow(3600.0, 9));
  EXPECT_EQ(ConvertedLiteral("0", "cm").AsReal(), 0);
}

std::string FaultsOf(const std::string& text) {
  return dsl::Render(CompileText("benchmark b { " + text + " }").diagnostics);
}

/// The settings of the only run.
plan::Scene SceneWith(const std::string& text) {
  const compiler::Compilation result = CompileText("benchmark b { " + text + " }");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.empty() ? plan::Scene() : result.plans[0].runs[0].scene;
}

TEST(Units, AUnitBelongsToTheProductBeforeIt) {
  EXPECT_EQ(SceneWith("timestep 10 ms").world.Real("timestep"), 0.01);
  EXPECT_EQ(SceneWith("timestep 1/60 s").world.Real("timestep"), 1.0 / 60);
  EXPECT_EQ(SceneWith("timeout 5 min").world.Real("timeout"), 300);
  EXPECT_EQ(SceneWith("memory 2 GB").world.Real("memory"), 2e9);
  EXPECT_EQ(SceneWith("let n = 4; timestep 10 ms / n").world.Real("timestep"), 0.0025);
  EXPECT_EQ(SceneWith("let n = 4; timestep (n) ms").world.Real("timestep"), 0.004);
  EXPECT_EQ(SceneWith("world.side 20 * 5 m + 50 cm").world.Real("world.side"), 100.5);
  EXPECT_EQ(SceneWith("objects.quantity 20 cm / 4 cm").groups[0].settings.Count("quantity"), 5u);
  EXPECT_EQ(SceneWith("acceleration (0, -981, 0) cm/s^2").world.Vector("acceleration"),
            Eigen::Vector3d(0, -9.81, 0));
}

TEST(Units, DistributionsAndSweepsTakeThem) {
  const plan::Scene scene = SceneWith("objects { size uniform(1, 5) cm; mass normal(5 g, 1 g) }");
  EXPECT_EQ(schema::ToText(scene.groups[0].settings.Get("size")), "uniform(0.01, 0.05)");
  EXPECT_EQ(schema::ToText(scene.groups[0].settings.Get("mass")), "normal(0.005, 0.001)");
  const compiler::Compilation result = CompileText(
      "benchmark b { objects.size sweep(1 .. 3) cm; timestep (sweep(5, 10) as step) ms }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  EXPECT_EQ(result.plans[0].axes[0].values, (std::vector<plan::Coordinate>{0.01, 0.02, 0.03}));
  EXPECT_EQ(result.plans[0].axes[1].values, (std::vector<plan::Coordinate>{0.005, 0.01}));
}

TEST(Units, ConditionsCompareInSi) {
  const compiler::Compilation result = CompileText(
      "benchmark b { objects.size sweep(1, 2, 5) cm; skip when size > 30 mm or size == 1 cm }");
  ASSERT_EQ(result.plans.size(), 1u) << dsl::Render(result.diagnostics);
  EXPECT_EQ(result.plans[0].runs.size(), 1u);
}

TEST(Units, WhatDoesNotFitIsOneError) {
  for (const char* text : {"objects.size 5 kg",
                           "cycles 5 s",
                           "memory 5 s",
                           "timeout 5 GB",
                           "memory 5 gb",
                           "let a = 5 kg; objects.size a",
                           "let a = 5 kg + 2 cm",
                           "objects.size 5 cm + 3",
                           "objects.linear_velocity (1, 2 cm/s, 3)",
                           "objects.mass uniform(1, 5 kg)",
                           "objects.size sweep(1 .. 5 cm)",
                           "objects.location ring(radius: 5 s)",
                           "skip when quantity > 5 cm",
                           "objects.aspect 1 : 2 cm : 3",
                           "objects.size (5 cm) cm",
                           "objects.size 5 cm^x",
                           "timestep 5 fortnight",
                           "timestep 5 seconds",
                           "let n = 5; timestep n ms",
                           "objects.type any(sphere 3, cone 1) cm",
                           "timestep 10ms"}) {
    const compiler::Compilation result = CompileText(std::string("benchmark b { ") + text + " }");
    EXPECT_EQ(result.diagnostics.error_count(), 1) << text << "\n"
                                                   << dsl::Render(result.diagnostics);
  }
  EXPECT_NE(FaultsOf("objects.size 5 kg").find("'size' is a length, but this is a mass"),
            std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
