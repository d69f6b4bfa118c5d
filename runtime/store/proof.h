// What is proven of a file of cdb before this process reads it as HDF5: that it is as it was
// sealed, and that HDF5 survives it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "runtime/store/hdf5/file.h"
#include "runtime/store/store.h"

namespace cdb::store {

/// The attribute of a file's root that says that the file has a seal; its text is for people.
inline constexpr const char* kDigestAttribute = "digest";
inline constexpr std::string_view kDigestText =
    "64-bit checksum of all bytes, in the last 24 bytes of the file; cdb check verifies it";

/// Of ProofOf::kFewValues.
inline constexpr std::uintmax_t kMostProven = 64 << 20;

/// Compares the file with its seal, if it has one. Then `read` opens the file and reads its
/// structure, and all values where its argument is true, in a process with limits
/// (limited_process.h). Throws StoreError, with `remedy` at its end, where the seal is broken or
/// `read` fails. True where there is a seal.
bool ProveFile(const std::filesystem::path& file, std::string_view remedy, ProofOf of,
               const std::function<void(bool reads_values)>& read);

/// Of an open file: throws hdf5::Error where it should have a seal and has none.
void RequireSeal(const hdf5::File& file, const std::filesystem::path& path);

/// Throws StoreError for an image that HDF5 does not survive. One that was proven is not read
/// again.
void ProveShard(const std::filesystem::path& path, std::span<const std::byte> image);

}  // namespace cdb::store
