// Atomic files: written under a temporary name, synced and renamed, so that they exist completely
// or not at all. Independent of HDF5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::files {

/// Throws StoreError if `folder` is not a folder. `use`: its expected contents, for the message.
void RequireFolder(const std::filesystem::path& folder, std::string_view use);

/// Writes `text` to `final_name` atomically; a symbolic link there is followed (temporary_file.h).
/// Throws StoreError, with nothing changed.
void WriteWhole(std::string_view text, const std::filesystem::path& final_name);

/// The same in pieces: `fill` is called once with a function that appends.
void WritePieces(const std::function<void(const std::function<void(std::string_view)>&)>& fill,
                 const std::filesystem::path& final_name);

}  // namespace cdb::files
