// Checks of a file of cdb before this process reads it as HDF5: that it is as it was sealed, and
// that it does not crash HDF5.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "runtime/results/files/limited_process.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"

namespace cdb::results {

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
