// Refuses what a file that cdb wrote never has, before HDF5 acts on it: values outside of the file,
// filters that a library of somebody else would run, types that need a conversion, and arrays that
// are larger than their file can hold. Included only by the sources of this folder.
#pragma once

#include <cstdint>

#include "runtime/store/hdf5/dataset.h"
#include "runtime/store/hdf5/object.h"

namespace cdb::hdf5 {

/// External links lead nowhere from now on, and HDF5 loads no filters; for the whole process.
void CloseBackdoors();

/// Throws Error where a link in the group `id` leads out of it, or is of a kind that files of cdb
/// do not have.
void CheckLinks(const Id& group);

/// `file_bytes`: length of the file that holds `dataset`. Throws Error.
void CheckStorage(const Id& dataset, std::uint64_t file_bytes);

/// The same before `values` of `item_bytes` each are read at once.
void CheckReadable(const Id& dataset, std::uint64_t values, std::uint64_t item_bytes,
                   std::uint64_t file_bytes);

}  // namespace cdb::hdf5
