// Which run of a sweep is shown: `axis=value` words to a cell.
#pragma once

#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/store.h"

namespace cdb::view {

/// A value as a user names it on an axis: `detector=dbvt`, `hz=60`, `rep=2`.
struct Selection {
  std::string axis, value;
};
/// Throws store::StoreError for a word without `=`.
Selection ParseSelection(const std::string& word);

/// The index of a coordinate: equal text, or a number that differs by less than 1e-4 of its size,
/// as tables show four digits; the nearest of several. Throws store::StoreError that names those of
/// the axis.
std::size_t FindCoordinate(const plan::Axis& axis, const std::string& value);

/// Changes the cell to what the selections name; the other axes stay. Throws store::StoreError for
/// an axis or a value that the sweep has not got.
void Select(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
            const std::vector<Selection>& selections, store::ResultFile::Cell& cell);

/// `detector dbvt, quantity 100, rep 0`; the repeat only where there are several. Empty for a
/// sweep of one run.
std::string CellName(const std::vector<plan::Axis>& axes, std::uint64_t repeats,
                     const store::ResultFile::Cell& cell);

}  // namespace cdb::view
