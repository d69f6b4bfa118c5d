// Checks a results file against its schema: shapes and types of its arrays, and the ranges of
// values. Throws hdf5::Error, which names the array.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"
#include "runtime/results/files/limited_process.h"
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

// Checks whether a results file matches the plan that it holds.

/// Checks that axes, repeats, type and shape of every array, and the run of every cell are those of
/// `plan`, and that durations are present if it records any. Throws hdf5::Error, which names the
/// difference.
void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents, const plan::Plan& plan);

/// The same with the plan of the file, which a file with a digest must have. Files of an earlier
/// version, and plans in the short form or in a format that this version does not read, are not
/// checked.
void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents,
                      const std::string& plan_text);

// Checks of a file of cdb before this process reads it as HDF5: that it is as it was sealed, and
// that it does not crash HDF5.

/// The attribute of a file's root that marks a file with a seal; its text is for people.
inline constexpr const char* kDigestAttribute = "digest";
inline constexpr std::string_view kDigestText =
    "64-bit checksum of all bytes, in the last 24 bytes of the file; cdb check verifies it";

/// Size limit for ProofOf::kFewValues.
inline constexpr std::uintmax_t kMostProven = 64 << 20;

/// The limits for reading a results file of `bytes` with all its values and its plan.
files::WorkLimits LimitsForEveryValue(std::uint64_t bytes);

/// Compares the file with its seal, if it has one. Then runs `read` in a process with limits
/// (limited_process.h): it opens the file and reads its structure, and all values if its argument
/// is true. Throws StoreError, with `remedy` at its end, if the seal is broken or `read` fails.
/// Returns true if there is a seal.
bool ProveFile(const std::filesystem::path& file, std::string_view remedy, ProofOf of,
               const std::function<void(bool reads_values)>& read);

/// For an open file: throws hdf5::Error if it should have a seal and has none.
void RequireSeal(const hdf5::File& file, const std::filesystem::path& path);

}  // namespace cdb::results
