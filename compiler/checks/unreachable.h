// What a benchmark says and no run has: values of axes, cases, axes and settings.
#pragma once

#include "compiler/grid/grid.h"
#include "compiler/scenario/scenario.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// Warns of what stands in the benchmark's own block, not of what it takes from a base: values of
/// an axis and cases that `skip` leaves out at every point, sweeps in a let that nothing uses, and
/// settings that every case overrides. `grid` is the benchmark's.
void ReportUnreachable(const scenario::Scenario& scenario, const scenario::BenchmarkRef& benchmark,
                       const grid::Grid& grid, dsl::Diagnostics& diagnostics);

/// Warns of a let of the file that is a sweep and that nothing uses.
void ReportUnusedSweep(const dsl::Let& let, dsl::Diagnostics& diagnostics);

}  // namespace cdb::checks
