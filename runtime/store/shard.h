// Opens shards, for merging and reading.
#pragma once

#include <filesystem>

#include "runtime/store/hdf5/file.h"

namespace cdb::store {

/// Opens a shard whose every byte is as it was written. Throws StoreError.
hdf5::File OpenShard(const std::filesystem::path& path);

}  // namespace cdb::store
