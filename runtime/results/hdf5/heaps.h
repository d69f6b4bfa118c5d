// Global heaps, in which HDF5 keeps texts of variable length (HDF5 File Format Specification,
// III.E).
#pragma once

#include <filesystem>

namespace cdb::hdf5 {

/// Rejects a heap with an object of size zero, on which HDF5 loops forever: it steps from object to
/// object by their sizes. Throws Error. A file that cannot be opened has no heaps.
void CheckGlobalHeaps(const std::filesystem::path& path);

}  // namespace cdb::hdf5
