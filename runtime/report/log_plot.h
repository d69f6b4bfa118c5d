// Points in a frame of characters, for a terminal.
#pragma once

#include <string>
#include <vector>

namespace cdb::report {

/// A point of the plot: both more than 0.
struct PlotPoint {
  double x, y;
  bool on_front;
};
/// The points in a frame of characters, both axes logarithmic; `*` on the front, `o` off it. Empty
/// for fewer than two points.
std::string LogPlot(const std::vector<PlotPoint>& points, const std::string& x_name,
                    const std::string& y_name);

}  // namespace cdb::report
