// Opening shards, for the merge and the reader.
#pragma once

#include <filesystem>

#include "runtime/store/hdf5_file.h"

namespace cdb::runtime {

/// Opens a shard whose every byte is as it was written. Throws StoreError.
h5::File OpenShard(const std::filesystem::path& path);

}  // namespace cdb::runtime
