// Which run of a sweep is shown: `axis=value` words to a cell.
#pragma once

#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/statistics/axis_values.h"
#include "runtime/store/store.h"

namespace cdb::view {

/// Changes the cell to what the selections name, one value of an axis each, or `rep=2`; the other
/// axes stay. Throws store::StoreError for an axis or a value that the sweep does not have.
void Select(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
            const std::vector<statistics::AxisSelection>& selections,
            store::ResultFile::Cell& cell);

/// `detector dbvt, quantity 100, rep 0`; the repeat only where there are several. Empty for a
/// sweep of one run.
std::string CellName(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
                     const store::ResultFile::Cell& cell);

}  // namespace cdb::view
