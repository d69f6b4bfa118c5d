// `cdb view --serve`: a scenario edited in a browser.
#pragma once

#include <optional>
#include <string>

#include "runtime/cli/options/subcommand.h"

namespace cdb::cli {

// `cdb view --serve`: a scenario edited in a browser.

/// Serves until Ctrl-C. `benchmark`: the first of the file by default. Throws CommandError for a
/// missing file, a scenario that comes with cdb, or an unknown benchmark.
options::ExitStatus ServeScenario(const std::string& file,
                                  const std::optional<std::string>& benchmark);

}  // namespace cdb::cli
