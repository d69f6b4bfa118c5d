// Selects the run of a sweep to show: turns `axis=value` words into a cell.
#pragma once

#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/figures/selection.h"
#include "runtime/results/store.h"

namespace cdb::view {

/// Changes the cell to the selected values, each `axis=value` or `rep=2`; other axes keep theirs.
/// Throws files::StoreError for an axis or a value that the sweep does not have.
void Select(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
            const std::vector<figures::AxisSelection>& selections, results::ResultFile::Cell& cell);

/// `detector dbvt, quantity 100, rep 0`; the repeat only if there are several. Empty for a sweep of
/// one run.
std::string CellName(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
                     const results::ResultFile::Cell& cell);

}  // namespace cdb::view
