// Checks whether a results file matches the plan that it holds.
#pragma once

#include <string>

#include "runtime/store/examine.h"
#include "runtime/store/hdf5/file.h"

namespace cdb::store {

/// Checks that axes, repeats, and type and shape of every array are those required by `plan_text`,
/// and that durations are present if it records any. A plan in the short form, or in a format that
/// this version does not read, is not checked. Throws hdf5::Error, which names the difference.
void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents,
                      const std::string& plan_text);

}  // namespace cdb::store
