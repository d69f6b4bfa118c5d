// `cdb check` for files that cdb wrote: results files, shards and traces.
#pragma once

#include <string>

#include "runtime/cli/options/exit_status.h"

namespace cdb::cli {

/// Reads every byte of `file`. Prints in one line whether it is as it was written, whether its runs
/// are those of its plan, and how many are missing (kRuns). Damage is an error (kWorld).
options::ExitStatus CheckStored(const std::string& file);

}  // namespace cdb::cli
