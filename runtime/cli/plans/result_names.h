// The names of results files: those that `cdb run` gives, and the results of a scenario.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace cdb::plans {

/// The results file of the benchmark `name` of `file`, a scenario or a plan, which has `plan_count`
/// plans to be run. If `out` is empty or a folder, it is `FILE.h5` there for a scenario with one
/// benchmark, else, and if `file` is empty, `NAME.h5`; else it is `out` itself. Results that an
/// earlier cdb named after the only benchmark of the scenario keep their name, which is said on
/// standard error. Throws CommandError if several benchmarks would share one file, if the folder
/// does not exist, or if there is a results file that would share its folder of runs (`r` for
/// `r.h5`).
std::filesystem::path ResultPath(const std::string& out, const std::string& name,
                                 const std::string& file, std::size_t plan_count);

/// The results that `name` means to a command that shows them: the file itself, or those that `cdb
/// run` has written into the current folder for the scenario `name`; for `x.h5` that is not there,
/// those of `x.cdb`. Throws CommandError, with the command that makes them, if there are none.
std::string FindResult(const std::string& name);

}  // namespace cdb::plans
