// Opens shards, for merging and reading.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "runtime/store/hdf5/file.h"

namespace cdb::shards {

/// Opens a shard and checks that it is byte for byte as it was written. Throws StoreError.
hdf5::File OpenShard(const std::filesystem::path& path);
/// The same for the bytes that ReadSealed read from `path`.
hdf5::File OpenShard(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace cdb::shards
