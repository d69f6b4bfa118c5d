// Whether a results file is of the plan that it holds.
#pragma once

#include <string>

#include "runtime/store/examine.h"
#include "runtime/store/hdf5/file.h"

namespace cdb::store {

/// Axes, repeats, and type and shape of every array are those that `plan_text` asks for; durations
/// are there if it records any. A plan in the short form, or of a format that this version does not
/// read, says nothing. Throws hdf5::Error, which names what differs.
void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents,
                      const std::string& plan_text);

}  // namespace cdb::store
