#include "runtime/figures/errors.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "dsl/diagnostics.h"
#include "tests/runtime/figures/made_up_file.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using figures::ErrorRow;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ErrorRow RowAt(double ms, double spread, double error, double error_spread = 0) {
  ErrorRow row;
  row.row = {{}, "", false, {}, 1};
  row.ms_per_s = {ms, {}, 5};
  row.time_interval = {ms - spread, ms + spread};
  row.error = error;
  row.error_interval = error_spread > 0
                           ? figures::Interval{error - error_spread, error + error_spread}
                           : figures::Interval{kNan, kNan};
  row.floor = kNan;
  return row;
}

std::string MarksOf(std::vector<ErrorRow> rows) {
  figures::MarkFront(rows);
  std::string marks;
  for (const ErrorRow& row : rows) marks += row.on_front ? '*' : row.is_tie ? '=' : 'o';
  return marks;
}

TEST(MarkFront, TiesWithinNoise) {
  // Equally accurate, and slower within the intervals; then slower beyond them.
  EXPECT_EQ(MarksOf({RowAt(10, 1, 0.1), RowAt(11, 1, 0.1), RowAt(13, 1, 0.1)}), "*=o");
  // Errors are repeatable: without an interval, a larger error is not a tie.
  EXPECT_EQ(MarksOf({RowAt(10, 1, 0.1), RowAt(11, 1, 0.11)}), "*o");
  EXPECT_EQ(MarksOf({RowAt(10, 1, 0.1, 0.02), RowAt(11, 1, 0.11, 0.02)}), "*=");
  EXPECT_EQ(MarksOf({RowAt(10, 1, 0.1), RowAt(20, 1, 0.05)}), "**");
  // An error is known only up to its floor.
  std::vector<ErrorRow> rows = {RowAt(10, 1, 0.1), RowAt(11, 1, 0.11)};
  rows[0].floor = rows[1].floor = 0.006;
  EXPECT_EQ(MarksOf(rows), "*=");
}

TEST(MarkFront, HasNoTiesWithoutIntervals) {
  EXPECT_EQ(MarksOf({RowAt(10, kNan, 0.1), RowAt(10.001, kNan, 0.1)}), "*o");
}

TEST(MarkFront, LeavesVoidAndUnsoundRowsOff) {
  std::vector<ErrorRow> rows = {RowAt(10, 1, 0.1), RowAt(5, 1, 0.01)};
  rows[1].row.is_void = true;
  EXPECT_EQ(MarksOf(rows), "*o");
  std::vector<ErrorRow> sorted = {RowAt(5, 1, 0.01), RowAt(10, 1, 0.1)};
  EXPECT_EQ(MarksOf(sorted), "*o");
  sorted[0].unsound = "tunnelled, 3 of 20 objects";  // its time counts, its motion does not
  EXPECT_EQ(MarksOf(sorted), "o*");
}

/// The axes of the scene, and whether `rows` has a front, in a file of a scenario.
std::string ScenesOf(const std::string& statements, const std::vector<std::string>& by = {}) {
  const compiler::Compilation compiled = CompileText(
      "benchmark b { cycles 4; record timing; objects { quantity 2; size 1 }\n" + statements +
      "\naccuracy { metrics position; interval 1/60; reference { timestep 1/960 } } }");
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  return WithMadeUpFile(
      compiled.plans.at(0), [](const plan::Run&) { return MadeUp{}; },
      [&](const results::ResultFile& file) {
        const figures::Model model(file);
        std::string text;
        for (const std::size_t axis : model.scene_axes()) text += model.axis(axis).name + " ";
        const figures::ErrorFigures all =
            figures::CollectErrors(model, {.error = "position", .by = by, .each = {}});
        return text + fmt::format("{} {}", all.tables.size(), all.has_fronts ? "fronts" : "tables");
      });
}

TEST(SceneAxes, AreThoseOnWhichTheSceneDepends) {
  const std::string steps = "solver.iterations sweep(5, 10);";
  EXPECT_EQ(ScenesOf(steps), "1 fronts");
  EXPECT_EQ(ScenesOf(steps + "objects.friction sweep(0, 0.5, 1)"), "friction 3 fronts");
  EXPECT_EQ(ScenesOf(steps + "let f = sweep(0, 0.5); objects.friction f * 2"), "f 2 fronts");
  EXPECT_EQ(ScenesOf("let hz = sweep(60, 120); timestep 1 / hz"), "1 fronts");
  EXPECT_EQ(ScenesOf("cases { few { solver.iterations 5 } many { solver.iterations 50 } }"),
            "1 fronts");
  EXPECT_EQ(
      ScenesOf(steps + "cases { rough { objects.friction 1 } smooth { objects.friction 0 } }"),
      "case 2 fronts");
}

TEST(SceneAxes, HaveNoFrontOverThem) {
  EXPECT_EQ(ScenesOf("objects.friction sweep(0, 0.5, 1)"), "friction 1 tables");
  const std::string both = "solver.iterations sweep(5, 10); objects.friction sweep(0, 0.5, 1)";
  EXPECT_EQ(ScenesOf(both, {"iterations", "friction"}), "friction 1 tables");
  EXPECT_EQ(ScenesOf(both, {"iterations"}), "friction 1 fronts");
}

TEST(ByReason, CountsThePointsOfEach) {
  const std::vector<figures::ErrorFigures::LeftOut> points = {
      {{0}, "chaos"}, {{1}, "a crash"}, {{2}, "chaos"}};
  const auto reasons = figures::ByReason(points);
  ASSERT_EQ(reasons.size(), 2u);
  EXPECT_EQ(reasons[0], (std::pair{&points[0], std::size_t{2}}));
  EXPECT_EQ(reasons[1], (std::pair{&points[1], std::size_t{1}}));
}

}  // namespace
}  // namespace cdb::tests
