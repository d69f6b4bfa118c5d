// The superblock at the beginning of an HDF5 file of version 1.10, with addresses and lengths of
// eight bytes (HDF5 File Format Specification 3.0, II.A). Included only by the sources of this
// folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace cdb::hdf5 {

/// True for a file of that kind without a user block.
bool HasSuperblock3(std::span<const std::byte> file);

/// The number of bytes that the superblock states.
std::uint64_t StatedBytes(std::span<const std::byte> file);

/// States the length of `file`, that nobody writes it, and the checksum of the superblock.
void CloseSuperblock(std::span<std::byte> file);

}  // namespace cdb::hdf5
