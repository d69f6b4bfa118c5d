// Path of the results of a plan, and the output after it has been executed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "runtime/cli/options/exit_status.h"

namespace cdb::plans {

/// `NAME.h5` in the current folder if `out` is empty, in `out` if that is a folder, else `out`
/// itself. `file`: the scenario, which has `plan_count` benchmarks. Throws CommandError if several
/// benchmarks would share one file, if the folder does not exist, or if there is a results file
/// that would share its folder of runs (`r` for `r.h5`).
std::filesystem::path ResultPath(const std::string& out, const std::string& name,
                                 const std::string& file, std::size_t plan_count);

/// Prints the summary of results that this process has merged or opened: their values have been
/// proven then. Exit status 3 if a run did not end well.
options::ExitStatus ShowResult(const std::filesystem::path& out, bool is_quiet);

}  // namespace cdb::plans
