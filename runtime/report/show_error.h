// Error against run time as tables and plots on a terminal (`cdb show --error`).
#pragma once

#include "runtime/report/show.h"
#include "runtime/statistics/error_figures.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// Each configuration, the fastest first: how much faster than real time it is, what a simulated
/// second takes (the statistic of cycle_times.h over the time step), its error, and whether it is
/// on the Pareto front: none is both faster and as accurate. A configuration that is worse than
/// those of the front only within the intervals ties with it. Intervals of times are of repeats;
/// those of errors are of seeds, where the file sweeps them. Void configurations are last, marked
/// and not on the front; those without the error or without a time are listed by themselves. Throws
/// StoreError, also for an error or an axis that the file has not got.
ShowText ShowError(const store::ResultFile& file, const statistics::ErrorOptions& options);

}  // namespace cdb::report
