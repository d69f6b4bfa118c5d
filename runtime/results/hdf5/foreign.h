// Rejects features that files written by cdb never have, before HDF5 acts on them: values outside
// of the file, filters of third-party libraries, types that need a conversion, and arrays that are
// larger than their file can hold. Included only by the sources of this folder.
#pragma once

#include <cstdint>

#include "runtime/results/hdf5/dataset.h"
#include "runtime/results/hdf5/object.h"

namespace cdb::hdf5 {

/// Disables external links and the loading of filters in HDF5, for the whole process.
void CloseBackdoors();

/// Throws Error if a link in the group `id` leads out of it, or is of a kind that files of cdb do
/// not have.
void CheckLinks(const Id& group);

/// `file_bytes`: length of the file that holds `dataset`. Throws Error.
void CheckStorage(const Id& dataset, std::uint64_t file_bytes);

/// The same check before `values` of `item_bytes` each are read at once.
void CheckReadable(const Id& dataset, std::uint64_t values, std::uint64_t item_bytes,
                   std::uint64_t file_bytes);

}  // namespace cdb::hdf5
