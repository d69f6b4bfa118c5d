// Error against run time, as tables and plots for a terminal (`cdb show --error`).
#pragma once

#include "runtime/report/show.h"
#include "runtime/statistics/error_figures.h"
#include "runtime/store/store.h"

namespace cdb::report {

/// Each configuration, the fastest first: its speed relative to real time, the time of a simulated
/// second (the statistic of cycle_times.h over the time step), its error, and whether it is on the
/// Pareto front, that is, no other is both faster and as accurate. A configuration that is worse
/// than those of the front only within the intervals ties with it. Intervals of times are over
/// repeats; those of errors are over seeds, if the file sweeps them. Void configurations are last,
/// marked and not on the front; those without the error or without a time are listed separately.
/// Throws StoreError, also for an error or an axis that the file does not have.
ShowText ShowError(const store::ResultFile& file, const statistics::ErrorOptions& options);

}  // namespace cdb::report
