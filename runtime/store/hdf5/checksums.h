// The checksums of HDF5. Included only by the sources of this folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace cdb::hdf5 {

/// Of a chunk: the last filter of its pipeline.
std::uint32_t Fletcher32(std::span<const std::byte> bytes);

/// Of metadata: Bob Jenkins' hash lookup3, from 0.
std::uint32_t Lookup3(std::span<const std::byte> bytes);

}  // namespace cdb::hdf5
