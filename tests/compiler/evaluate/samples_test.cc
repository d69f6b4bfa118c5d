#include "compiler/evaluate/samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using evaluate::LatinCoordinates;
using evaluate::SobolCoordinates;

std::size_t PartOf(double coordinate, std::size_t parts) {
  return static_cast<std::size_t>(coordinate * static_cast<double>(parts));
}

/// Whether each of `parts` equal intervals holds one coordinate.
bool IsEven(const std::vector<double>& coordinates) {
  std::set<std::size_t> parts;
  for (const double coordinate : coordinates)
    if (coordinate > 0 && coordinate < 1) parts.insert(PartOf(coordinate, coordinates.size()));
  return parts.size() == coordinates.size();
}

TEST(Samples, HaveOnePointInEachPartOfEveryDimension) {
  for (std::size_t dimension = 0; dimension < evaluate::kMostDimensions; ++dimension) {
    for (const std::size_t count : {1, 2, 64, 1024})
      EXPECT_TRUE(IsEven(SobolCoordinates(dimension, count))) << dimension << " " << count;
    for (const std::size_t count : {1, 7, 100})
      EXPECT_TRUE(IsEven(LatinCoordinates(dimension, count))) << dimension << " " << count;
  }
}

/// The first two dimensions are a (0, 2)-sequence: one point in each box of 2^a x 2^b.
TEST(Samples, OfSobolFillTheFirstTwoDimensionsInEveryShapeOfBox) {
  const std::vector<double> x = SobolCoordinates(0, 256), y = SobolCoordinates(1, 256);
  for (std::size_t wide = 1; wide <= 256; wide *= 2) {
    std::set<std::pair<std::size_t, std::size_t>> boxes;
    for (std::size_t i = 0; i < x.size(); ++i)
      boxes.emplace(PartOf(x[i], wide), PartOf(y[i], 256 / wide));
    EXPECT_EQ(boxes.size(), 256u) << wide;
  }
}

TEST(Samples, OfSobolKeepTheirFirstPoints) {
  const std::vector<double> few = SobolCoordinates(5, 50), many = SobolCoordinates(5, 500);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
}

/// Integrals over all dimensions, whose values are known: of a product, and of the correlation of
/// two dimensions. Random points would miss them by 2 % and 0.03.
TEST(Samples, IntegrateBetterThanRandomPoints) {
  constexpr std::size_t kCount = 1024;
  std::vector<std::vector<double>> dimensions;
  for (std::size_t i = 0; i < evaluate::kMostDimensions; ++i)
    dimensions.push_back(SobolCoordinates(i, kCount));
  double sum = 0;
  for (std::size_t point = 0; point < kCount; ++point) {
    double product = 1;
    for (const auto& coordinates : dimensions) product *= 1 + 0.5 * (coordinates[point] - 0.5);
    sum += product;
  }
  EXPECT_NEAR(sum / kCount, 1, 4e-3);
  for (std::size_t i = 0; i < dimensions.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      double correlation = 0;
      for (std::size_t point = 0; point < kCount; ++point)
        correlation += 12 * (dimensions[i][point] - 0.5) * (dimensions[j][point] - 0.5) / kCount;
      EXPECT_LT(std::abs(correlation), 0.02) << i << " " << j;
    }
}

TEST(Samples, AreAnAxisOfNumberedPointsWithCoordinates) {
  const std::string text =
      "let side, hz = zip(sweep(10 .. 1000 sobol 8 log), sweep(60 .. 240 sobol 8)) as design\n"
      "benchmark b { world.side side; timestep 1 / hz }";
  const compiler::Compilation result = CompileText(text);
  ASSERT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  const plan::Plan& plan = result.plans.at(0);
  ASSERT_EQ(plan.axes.size(), 1u);
  EXPECT_EQ(plan.axes[0].name, "design");
  EXPECT_EQ(std::get<double>(plan.axes[0].values.at(7)), 8);
  ASSERT_EQ(plan.axes[0].sampled.size(), 2u);
  const plan::Coordinates &side = plan.axes[0].sampled[0], &hz = plan.axes[0].sampled[1];
  EXPECT_EQ(side.name, "side");
  EXPECT_TRUE(side.is_log);
  EXPECT_EQ(side.last, 1000);
  EXPECT_FALSE(hz.is_log);
  std::vector<double> decades;
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(plan.runs.at(i).scene.world.Real("world.side"), side.values[i]);
    EXPECT_EQ(plan.runs.at(i).scene.world.Real("timestep"), 1 / hz.values[i]);
    decades.push_back(std::log10(side.values[i] / 10) / 2);
  }
  EXPECT_TRUE(IsEven(decades));
  // More points are the same runs, and others.
  std::string more = text;
  for (std::size_t at; (at = more.find("sobol 8")) != std::string::npos;)
    more.replace(at, 7, "sobol 16");
  const compiler::Compilation extended = CompileText(more);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(extended.plans.at(0).runs.at(i).id, plan.runs[i].id);
}

TEST(Samples, MayHavePercentages) {
  for (const char* text :
       {"let a, b = zip(sweep(0 % .. 50 % sobol 4), sweep(1 % .. 2 % sobol 4 log)) as d\n"
        "benchmark b { objects.restitution a; objects.friction b; skip when a > 20 % or b > 3 % }",
        "benchmark b { objects.friction sweep(10 % .. 50 % count 3) as mu }"})
    EXPECT_FALSE(CompileText(text).diagnostics.has_errors())
        << dsl::Render(CompileText(text).diagnostics);
}

TEST(Samples, AreRefusedWhereTheyMakeNoSense) {
  struct Case {
    const char *text, *message;
  };
  constexpr Case kCases[] = {
      {"benchmark b { world.side sweep(10 .. 20 sobol 8) }",
       "'sobol' varies several values at once, and this is one"},
      {"let a, b = zip(sweep(10 .. 20 sobol 8), sweep(1 .. 2 sobol 8))\n"
       "benchmark b { world.side a; timestep 1 / b }",
       "these points have no name"},
      {"let a, b = zip(sweep(10 .. 20 sobol 2), sweep(1, 2)) as d\n"
       "benchmark b { world.side a; timestep 1 / b }",
       "only some of these ranges are sampled, or not in the same way"},
      {"let a, b = zip(sweep(10 .. 20 sobol 2), sweep(1 .. 2 latin 2)) as d\n"
       "benchmark b { world.side a; timestep 1 / b }",
       "only some of these ranges are sampled, or not in the same way"},
      {"let a, b = zip(sweep(10 .. 20 sobol 2, 4), sweep(1 .. 2 sobol 2)) as d\n"
       "benchmark b { world.side a; timestep 1 / b }",
       "a range with 'sobol' is the only argument of its sweep"},
      {"let a, b = zip(sweep(0 .. 20 sobol 2 log), sweep(1 .. 2 sobol 2)) as d\n"
       "benchmark b { world.side a; timestep 1 / b }",
       "a logarithmic range must be above 0"},
      {"let a, b = zip(sweep(10 .. 20 sobol 2 count 3), sweep(1 .. 2 sobol 2)) as d\n"
       "benchmark b { world.side a; timestep 1 / b }",
       "a range can have one of 'step', 'count', 'sobol' and 'latin'"},
      {"let d, s = zip(sweep(sap, dbvt), sweep(10 .. 20 sobol 2)) as design\n"
       "benchmark b { world.side s; detector d }",
       "only some of these ranges are sampled, or not in the same way"},
      {"let a, b = zip(sweep(10 .. 20 sobol 2), sweep(1 .. 2 sobol 2)) as a\n"
       "benchmark b { world.side a; timestep 1 / b }",
       "'a' would be the name of two arrays of /sampled in the results"},
      {"let a, b = zip(sweep(0 .. 1 sobol 2), sweep(10 .. 20 sobol 2)) as d\n"
       "benchmark b { world.side b; cases m { x { objects.restitution a } y { world.side 15 } } }",
       "'d' is not used in every case"},
      {"let requirements = sweep(1, 2)\nbenchmark b { cycles requirements }",
       "an axis cannot be called 'requirements', which is the name of a group of the results"},
      {"let a, b = zip(sweep(10 .. 20 sobol 4), sweep(1 .. 2 sobol 2)) as d\n"
       "benchmark b { world.side a; timestep 1 / b }",
       "the sweeps of zip() have 4 and 2 values"},
  };
  for (const Case& one : kCases) {
    const compiler::Compilation result = CompileText(one.text);
    ASSERT_GT(result.diagnostics.error_count(), 0) << one.text;
    EXPECT_EQ(result.diagnostics.all()[0].message, one.message) << one.text;
  }
}

}  // namespace
}  // namespace cdb::tests
