// `cdb view --serve`: a scenario edited in a browser.
#pragma once

#include <optional>
#include <string>

#include "runtime/cli/options/exit_status.h"

namespace cdb::cli {

/// Serves until Ctrl-C. `benchmark`: default, the first of the file. Throws CommandError for a file
/// that is not there, a scenario that comes with cdb, or a benchmark that it has not got.
options::ExitStatus ServeScenario(const std::string& file,
                                  const std::optional<std::string>& benchmark);

}  // namespace cdb::cli
