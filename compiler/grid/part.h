// Parts of a grid that is too large to list: the number of a part determines its runs.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "compiler/grid/grid.h"
#include "compiler/plan/plan.h"

namespace cdb::grid {

/// The hash covers axes, repeats, settings, conditions and plug-ins, which determine the runs,
/// instead of the runs themselves; so the time depends on the number of values in settings. Leaves
/// the short text empty. Runs are made anew for each visit.
plan::WholePlan MakeWhole(std::shared_ptr<const Grid> grid);

/// The part numbered `index`, from 0, of `count`.
struct Part {
  std::uint64_t index = 0;
  std::uint64_t count = 1;
};

/// The runs of one part, in grid order, with references. Runs that differ only in the detector are
/// in the same part. Neighbouring points of the grid are in different parts, so that all parts have
/// about the same work; part I of N consists of the parts I*S to I*S+S-1 of N*S. `whole`: that of
/// the grid.
plan::Plan ListPart(const Grid& grid, std::shared_ptr<const plan::WholePlan> whole, Part part);

}  // namespace cdb::grid
