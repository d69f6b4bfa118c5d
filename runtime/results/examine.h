// Checks a results file against its schema: shapes and types of its arrays, and the ranges of
// values. Throws hdf5::Error, which names the array.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"

namespace cdb::results {

/// The properties that determine the shapes of a results file.
struct FileExtents {
  int version = 0;   ///< of the schema
  hdf5::Shape grid;  ///< extents of the axes and of `rep`
  std::uint64_t cycles = 0;
};

/// Checks that every series and every run fact in the file has the dimensions of the grid and its
/// own.
void CheckArrays(const hdf5::File& file, const FileExtents& extents);

/// `array`: its name in this version. Throws for durations and counts below zero, an unknown
/// status, and more cycles than exist. NaN means no value.
void CheckValues(std::string_view array, std::span<const double> values,
                 const FileExtents& extents);

/// Why the values of a run of `cycles` cycles cannot be those of a run: CheckValues, and in a run
/// that is done no cycle without times or pairs that were to be recorded. Empty if they can.
std::string FindFault(const RunResult& result, std::uint64_t cycles);

/// Reads all text and all numbers. `visit` receives the numbers piece by piece, with the path of
/// their array in the file.
void ReadEverything(
    const hdf5::File& file,
    const std::function<void(const std::string& path, std::span<const double> piece)>& visit);

/// The same with CheckValues.
void CheckAllValues(const hdf5::File& file, const FileExtents& extents);

}  // namespace cdb::results
