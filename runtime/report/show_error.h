// Error against run time as tables and plots on a terminal (`cdb show --error`).
#pragma once

#include <string>
#include <vector>

#include "runtime/report/show.h"
#include "runtime/store/store.h"

namespace cdb::report {

struct ShowErrorOptions {
  std::string error;  ///< an array of /accuracy: `position`
  /// Axes that make the rows; over the others errors are averaged and times pooled. Empty: all.
  std::vector<std::string> by;
  /// Axes each value of which has a table and a front of its own: other scenes than the rest.
  std::vector<std::string> each;
};

/// Each configuration, the fastest first: how much faster than real time it is, what a simulated
/// second takes, its error, and whether it is on the Pareto front: none is both faster and as
/// accurate. Times are of the whole cycle, the median of the repeats and between them the 5th and
/// 95th percentile. Configurations that did not end well, and those without the error, are listed
/// by themselves. Throws StoreError, also for an error or an axis that the file has not got.
ShowText ShowError(const store::ResultFile& file, const ShowErrorOptions& options);

}  // namespace cdb::report
