// `cdb check` for files that cdb wrote: results files, journals and traces.
#pragma once

#include <string>

#include "runtime/cli/options/subcommand.h"

namespace cdb::cli {

/// True if the file is one of them, or has the name of one.
bool IsStored(const std::string& file);

/// Reads every byte of `file`. Prints in one line whether it is as it was written, whether its runs
/// are those of its plan, and how many are missing (kFailedRuns). Damage is an error
/// (kEnvironmentError).
options::ExitStatus CheckStored(const std::string& file);

}  // namespace cdb::cli
