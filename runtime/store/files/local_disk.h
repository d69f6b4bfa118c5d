// Which file systems this machine alone writes to.
#pragma once

#include <filesystem>

namespace cdb::files {

/// Files that other processes write to `path` are visible at once. False if that is not known, as
/// on NFS.
bool IsOnLocalDisk(const std::filesystem::path& path);

}  // namespace cdb::files
