// Parts of a benchmark that no run uses: values of axes, cases, axes and settings.
#pragma once

#include "compiler/grid/grid.h"
#include "compiler/scenario/scenario.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// Warns of parts of the benchmark's own block, not of those from a base: values of an axis and
/// cases that `skip` leaves out at every point, sweeps in an unused let, and settings that every
/// case overrides. `grid` is the benchmark's.
void ReportUnreachable(const scenario::Scenario& scenario, const scenario::BenchmarkRef& benchmark,
                       const grid::Grid& grid, dsl::Diagnostics& diagnostics);

/// Warns of an unused let of the file that is a sweep.
void ReportUnusedSweep(const dsl::Let& let, dsl::Diagnostics& diagnostics);

}  // namespace cdb::checks
