// Checks of a large grid are made once for all runs that agree in the settings read, and none is
// missed.
#include "compiler/grid/survey.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "compiler/compile.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "dsl/diagnostics.h"

namespace cdb::tests {
namespace {

constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();

/// Compiles without listing the runs.
compiler::Compilation GridsOf(const std::string& text) {
  const auto read = [&](const std::string&, std::string&) { return std::optional(text); };
  compiler::CompileOptions options;
  options.lists_runs = false;
  return compiler::Compile("test.cdb", read, options);
}

grid::Grid GridOf(const std::string& text) {
  compiler::Compilation result = GridsOf(text);
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.grids.at(0);
}

/// Three axes of 100 values.
constexpr const char* kMillion =
    "benchmark b { cycles sweep(1 .. 100); seed sweep(1 .. 100)\n"
    "objects { size 1; quantity sweep(1 .. 100) }";

TEST(Grid, CountsRunsWithoutMakingThem) {
  EXPECT_EQ(GridOf(std::string(kMillion) + "}").run_count(), 1'000'000u);
  EXPECT_EQ(GridOf(std::string(kMillion) + "; repeats 7 }").run_count(), 7'000'000u);
  EXPECT_EQ(GridOf(std::string(kMillion) + "skip when cycles > 5 and seed != 3 }").run_count(),
            5u * 10'000 + 95 * 100);
  EXPECT_EQ(GridOf(std::string(kMillion) + "skip when cycles == quantity }").run_count(), 990'000u);
  EXPECT_EQ(GridOf(std::string(kMillion) + "cases { a { } b { seed 5 } } }").run_count(),
            1'010'000u);
}

TEST(Grid, LimitsTheRunsThatAreLeft) {
  const std::string large =
      "benchmark b { seed sweep(1 .. 1000); cycles sweep(1 .. 1000); warmup sweep(1 .. 200)\n";
  const auto result = GridsOf(large + "}");
  ASSERT_EQ(result.diagnostics.error_count(), 1);
  EXPECT_EQ(result.diagnostics.all()[0].kind, &scenario::kTooManyRuns);
  EXPECT_EQ(result.diagnostics.all()[0].message, "with this sweep there are 200000000 points");
  EXPECT_EQ(GridOf(large + "skip when warmup > 1 }").run_count(), 1'000'000u);
}

TEST(Grid, HasTheScenesOfItsList) {
  const grid::Grid grid = GridOf(
      "let k = sweep(1, 2, 3)\n"
      "benchmark b { cycles sweep(4, 5); objects { size k; quantity 10 * k; mass sweep(1, 2) }\n"
      "cases { a { } b { seed sweep(1, 2); objects.mass uniform(1, k) } }; repeats 2\n"
      "skip when cycles == 5 and k == 2 }");
  const plan::Plan plan = grid::ListRuns(grid);
  ASSERT_EQ(plan.runs.size(), grid.run_count());
  grid::Cursor cursor(grid);
  // In reverse order, so that settings change in a different order than in the list.
  for (auto run = plan.runs.rbegin(); run != plan.runs.rend(); ++run) {
    ASSERT_TRUE(cursor.MoveTo(run->at));
    EXPECT_EQ(cursor.MakeScene(), run->scene);
  }
  for (const auto& point : plan.skipped) EXPECT_FALSE(cursor.MoveTo(point));
}

TEST(Survey, LooksOnceAtEachCombinationOfWhatIsRead) {
  const grid::Grid grid = GridOf(std::string(kMillion) + "skip when seed > 50 }");
  grid::Survey survey(grid);
  std::size_t looks = 0;
  std::uint64_t points = 0;
  const bool is_whole = survey.Look(
      kAll, {},
      [&](bool) {
        looks = 0;
        points = 0;
      },
      [&](const grid::Sample& sample, const plan::Scene& scene) {
        // Reads the number of cycles of only half the scenes.
        if (scene.ObjectCount() > 50) scene.world.Count("cycles");
        ++looks;
        points += sample.points;
      });
  EXPECT_TRUE(is_whole);
  EXPECT_EQ(looks, 10'000u);
  EXPECT_EQ(points, grid.point_count);
}

TEST(Survey, SaysWhereItLooksAtAPart) {
  const grid::Grid grid = GridOf(std::string(kMillion) + "}");
  grid::Survey survey(grid);
  std::uint64_t least = kAll, most = 0, looks = 0;
  EXPECT_FALSE(survey.Look(
      500, {}, [&](bool) { looks = 0; },
      [&](const grid::Sample&, const plan::Scene& scene) {
        const std::uint64_t here = scene.ObjectCount() * scene.world.Count("cycles");
        least = std::min(least, here);
        most = std::max(most, here);
        ++looks;
      }));
  EXPECT_LT(looks, 600u);
  EXPECT_EQ(least, 1u);
  EXPECT_EQ(most, 10'000u);
}

TEST(Survey, FindsTheOneBadRunOfAMillion) {
  const auto result = GridsOf(
      "benchmark b { cycles sweep(1 .. 100); seed sweep(1 .. 100); detector sap\n"
      "objects { size 1; quantity sweep(16279 .. 16378) } objects more { quantity sweep(1 .. 100) "
      "}\n"
      "skip when objects.quantity + more.quantity > 16378 and more.quantity < 100 }");
  ASSERT_EQ(result.diagnostics.error_count(), 1);
  EXPECT_EQ(result.diagnostics.all()[0].kind, &scenario::kCapacity);
  // Values outside a setting's domain are found as well, unless they are skipped.
  const std::string text =
      "benchmark b { cycles sweep(1 .. 100); seed sweep(1 .. 100)\n"
      "objects { size 1; friction sweep(0 .. 100) - 50; quantity 1 }\n";
  EXPECT_TRUE(GridsOf(text + "}").diagnostics.has_errors());
  EXPECT_FALSE(GridsOf(text + "skip when objects.friction < 0 }").diagnostics.has_errors());
}

}  // namespace
}  // namespace cdb::tests
