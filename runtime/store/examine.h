// Whether a results file is what its schema says: shapes and types of its arrays, and values that
// are possible. Throws hdf5::Error, which names the array.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "runtime/store/hdf5/file.h"

namespace cdb::store {

/// What the shapes of a results file or a shard follow from.
struct FileExtents {
  int version = 0;   ///< of the schema
  hdf5::Shape grid;  ///< extents of the axes and of `rep`
  std::uint64_t cycles = 0;
};

/// Every series and every fact of a run that the file has is over the grid and its own dimensions.
void CheckArrays(const hdf5::File& file, const FileExtents& extents);

/// `array`: as this version names it. Durations and counts below zero, an unknown status and more
/// cycles than there are, are refused; NaN is no value.
void CheckValues(std::string_view array, std::span<const double> values,
                 const FileExtents& extents);

/// Reads everything: all text, and all numbers, which `visit` gets piece by piece with the path of
/// their array as it stands in the file.
void ReadEverything(
    const hdf5::File& file,
    const std::function<void(const std::string& path, std::span<const double> piece)>& visit);

/// The same with CheckValues, of a results file or a shard.
void CheckAllValues(const hdf5::File& file, const FileExtents& extents);

}  // namespace cdb::store
