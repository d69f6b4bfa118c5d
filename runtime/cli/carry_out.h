// A plan to its results file: runs what is missing, merges the shards, removes them.
#pragma once

#include <cstddef>
#include <filesystem>

#include "compiler/plan.h"
#include "runtime/schedule/schedule.h"
#include "runtime/schedule/stop.h"
#include "runtime/store/store.h"

namespace cdb::runtime {

struct CarryOutOptions {
  std::filesystem::path out;  ///< the results file; its shards lie beside it
  std::size_t jobs = 1;
  ShardChoice shard = {};
  bool fresh = false;     ///< start over
  bool is_quiet = false;  ///< no progress
};

struct CarriedOut {
  Summary summary;  ///< nothing where all was there already
  std::filesystem::path shards;
  bool is_merged = false;  ///< `out` is complete; not where only a shard of it was asked for
};

/// Goes on where an earlier call stopped. Stopped by a signal, says so and keeps what ended. Throws
/// CommandError, StoreError; then everything finished is kept. Threads: one.
CarriedOut CarryOut(const compiler::Plan& plan, const CarryOutOptions& options,
                    const Provenance& provenance, const StopFlag& stop);

}  // namespace cdb::runtime
