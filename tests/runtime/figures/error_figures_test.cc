#include "runtime/figures/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

TEST(MarkFront, LeavesVoidRowsOff) {
  std::vector<ErrorRow> rows = {RowAt(10, 1, 0.1), RowAt(5, 1, 0.01)};
  rows[1].row.is_void = true;
  EXPECT_EQ(MarksOf(rows), "*o");
}

}  // namespace
}  // namespace cdb::tests
