// The size of a data set's chunks.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/results/hdf5/file.h"

namespace cdb::hdf5 {

/// One chunk fits HDF5's chunk cache of 1 MiB.
inline constexpr std::uint64_t kLargestChunk = (1 << 20) - 1;

/// Splits dimension `i` of a chunk evenly into the fewest pieces of at most `kLargestChunk` bytes;
/// into single items if even those are too large.
void SplitEvenly(Shape& chunk, std::size_t i, std::size_t item_bytes);

}  // namespace cdb::hdf5
