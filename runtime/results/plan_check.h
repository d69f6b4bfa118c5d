// Checks whether a results file matches the plan that it holds.
#pragma once

#include <string>

#include "compiler/plan/plan.h"
#include "runtime/results/examine.h"
#include "runtime/results/hdf5/file.h"

namespace cdb::results {

/// Checks that axes, repeats, type and shape of every array, and the run of every cell are those of
/// `plan`, and that durations are present if it records any. Throws hdf5::Error, which names the
/// difference.
void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents, const plan::Plan& plan);

/// The same with the plan of the file, which a file with a digest must have. Files of an earlier
/// version, and plans in the short form or in a format that this version does not read, are not
/// checked.
void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents,
                      const std::string& plan_text);

}  // namespace cdb::results
