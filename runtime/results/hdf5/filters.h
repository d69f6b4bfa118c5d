// The filters of chunks, as HDF5 applies them: the bytes of a chunk can be made, stored elsewhere
// and written into a file later. Source: HDF5 File Format Specification 3.0, III.A.2 and IV.A.2.l.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/results/hdf5/object.h"

namespace cdb::hdf5 {

/// A number after HDF5 has converted it to `type`.
double AsStored(double value, Type type);

/// The stored form of `values`, of `item_bytes` each, in a dataset with filters: shuffled and
/// compressed, followed by a Fletcher-32 checksum. Throws Error.
std::vector<std::byte> Filtered(std::span<const std::byte> values, std::size_t item_bytes);

/// The inverse. Throws Error if the result has not `values_bytes` bytes or its checksum differs.
std::vector<std::byte> Unfiltered(std::span<const std::byte> stored, std::size_t item_bytes,
                                  std::size_t values_bytes);

/// Compressed only. The inverse throws Error for what `Deflated` did not make.
std::vector<std::byte> Deflated(std::span<const std::byte> bytes);
std::vector<std::byte> Inflated(std::span<const std::byte> deflated, std::size_t bytes);

}  // namespace cdb::hdf5
