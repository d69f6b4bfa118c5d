// A layout written into a file, and the attributes by which a file is known.
#pragma once

#include <string>
#include <string_view>

#include "compiler/plan/plan.h"
#include "runtime/store/hdf5/file.h"
#include "runtime/store/layout.h"

namespace cdb::store {

/// Makes every dataset, with scales and attributes; coordinates are filled, arrays are not.
void CreateArrays(hdf5::File& file, const Layout& layout);

/// The attributes of the file itself. `what` is the line of `history`.
void WriteHead(hdf5::File& file, const plan::Plan& plan, const PlanFacts& facts,
               std::string_view what);

/// The same attributes of a copy of such a file, where they differ: `history` and `date_created`.
void RenewHead(hdf5::File& file, std::string_view what);

}  // namespace cdb::store
