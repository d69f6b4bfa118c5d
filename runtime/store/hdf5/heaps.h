// Global heaps, in which HDF5 keeps texts of any length (HDF5 File Format Specification, III.E).
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace cdb::hdf5 {

/// Refuses a heap with an object of size zero, on which HDF5 loops for ever: it steps from object
/// to object by their sizes. Throws Error.
void CheckGlobalHeaps(std::span<const std::byte> file);
/// The same of a file on disk; one that cannot be opened has no heaps.
void CheckGlobalHeaps(const std::filesystem::path& path);

}  // namespace cdb::hdf5
