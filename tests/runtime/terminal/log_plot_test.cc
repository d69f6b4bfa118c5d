// Plots of any numbers stay within their area.
#include "runtime/terminal/log_plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace cdb::tests {
namespace {

constexpr terminal::PlotMark kOff = terminal::PlotMark::kOff;

TEST(LogPlot, AnyRangeStaysWithinItsLines) {
  constexpr double kLeast = std::numeric_limits<double>::denorm_min(),
                   kMost = std::numeric_limits<double>::max();
  for (const double low : {kLeast, 0.0, -1.0, 1.0})
    for (const double high : {kMost, HUGE_VAL, std::nan(""), 2.0}) {
      const std::string text =
          terminal::LogPlot({{low, high, kOff, 0}, {high, low, kOff, 0}}, "x", "y");
      EXPECT_NE(text.find('o'), std::string::npos) << low << " " << high;
      std::size_t longest = 0;
      for (std::size_t at = 0, end = 0; end != std::string::npos; at = end + 1) {
        end = text.find('\n', at);
        longest = std::max(longest, std::min(end, text.size()) - at);
      }
      EXPECT_LE(longest, 90u);
    }
}

TEST(LogPlot, EndsAreInTheCorners) {
  const std::string text =
      terminal::LogPlot({{1e-300, 1e-300, kOff, 0}, {1e300, 1e300, kOff, 0}}, "x", "y");
  EXPECT_NE(text.find("|o"), std::string::npos) << text;
  EXPECT_NE(text.find(std::string(59, ' ') + "o\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace cdb::tests
