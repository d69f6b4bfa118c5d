// Tells whether other machines may write to a file system.
#pragma once

#include <filesystem>

namespace cdb::files {

/// True if files that other processes write to `path` are visible at once. False if that is
/// unknown, as on NFS.
bool IsOnLocalDisk(const std::filesystem::path& path);

}  // namespace cdb::files
