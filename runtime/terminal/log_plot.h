// A scatter plot of characters, for a terminal.
#pragma once

#include <string>
#include <vector>

namespace cdb::terminal {

/// The kind of a point; of points at one position, the last in this order is drawn.
enum class PlotMark { kVoid, kOff, kTie, kFront };

/// A point of the plot; both coordinates are positive.
struct PlotPoint {
  double x, y;
  PlotMark mark;
  char letter = 0;  ///< drawn in place of the mark's character
};
/// The points in a frame of characters, both axes logarithmic; `*` on the front, `=` for a tie with
/// it, `o` off it, `x` for a void one. Empty for fewer than two points.
std::string LogPlot(const std::vector<PlotPoint>& points, const std::string& x_name,
                    const std::string& y_name);

}  // namespace cdb::terminal
