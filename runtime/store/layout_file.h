// Writes a layout into a file, and the attributes that identify the file.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/hdf5/file.h"
#include "runtime/store/layout.h"

namespace cdb::store {

/// Creates every dataset, with scales and attributes. Coordinates are filled, arrays are not.
void CreateArrays(hdf5::File& file, const Layout& layout);

/// The same for the file of one run, which a merge makes redundant, in a third of the bytes.
/// Numbers have units and flags; scales, descriptions and declared fill values, which a merge takes
/// from the layout, are left out. Coordinates of text are not filled, so that they share a heap
/// with the texts of the run.
void CreateSmallArrays(hdf5::File& file, const Layout& layout);

/// The arrays and coordinates in a group: `` for the root, `run/`.
hdf5::ExpectedMembers MembersOf(const Layout& layout, std::string_view group);

/// Writes the attributes of the file itself. `what` is the line of `history`.
void WriteHead(hdf5::File& file, const plan::Plan& plan, const PlanFacts& facts,
               std::string_view what);

/// The attributes of the head that differ between files of the same plan, with their names.
using HeadTexts = std::vector<std::pair<const char*, std::string>>;
HeadTexts DatedHead(std::string_view what);

}  // namespace cdb::store
