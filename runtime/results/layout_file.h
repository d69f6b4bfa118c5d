// Writes a layout into a file, and the attributes that identify the file.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/layout.h"

namespace cdb::results {

/// Creates every dataset, with scales and attributes. Coordinates are filled, arrays are not.
void CreateArrays(hdf5::File& file, const Layout& layout);

/// Writes the attributes of the file itself. `what` is the line of `history`.
void WriteHead(hdf5::File& file, const plan::Plan& plan, const PlanFacts& facts,
               std::string_view what);

}  // namespace cdb::results
