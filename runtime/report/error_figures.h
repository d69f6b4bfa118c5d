// Errors against run times, before they are formatted (`cdb show --error`).
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "runtime/report/figures.h"
#include "runtime/report/show_error.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// One configuration: its repeats together, and all points of the axes that are not shown.
struct ErrorRow {
  Point at;                      ///< on the axes that make the rows
  std::vector<double> ms_per_s;  ///< of each run, sorted
  std::vector<double> errors, floors;
  double horizon = std::numeric_limits<double>::quiet_NaN();  ///< the shortest
  bool on_front = false;

  double Error() const;
  double Floor() const;
  /// What is known of the error: a smaller one than its floor is not better.
  double Known() const;
  double Time() const { return Percentile(ms_per_s, 0.5); }
  /// Simulated seconds in a second.
  double RealTimeFactor() const { return 1000 / Time(); }
  bool IsBelowFloor() const { return Error() < Floor(); }
};

struct ErrorFigures {
  /// A point without an error or a time.
  struct LeftOut {
    Point at;
    std::string why;
  };
  std::vector<std::size_t> rows, each;  ///< axes
  /// By the point on the axes `each`: the fastest first, and the front marked.
  std::map<Point, std::vector<ErrorRow>> tables;
  std::vector<LeftOut> left_out;
  std::size_t bad_cells = 0;
};

/// Throws StoreError, also for an error or an axis that the file has not got.
ErrorFigures CollectErrors(const store::ResultFile& file, const ShowErrorOptions& options);

}  // namespace cdb::report
