// Where the results of a plan go, and what is shown of them when they are there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "runtime/cli/options/exit_status.h"

namespace cdb::plans {

/// `NAME.h5` here where `out` is empty, in it where it is a folder, else `out` itself. `file`: the
/// scenario, which has `plan_count` benchmarks. Throws CommandError where one file would get
/// several, there is no such folder, or a results file is there that would share its shards (`r`
/// for `r.h5`).
std::filesystem::path ResultPath(const std::string& out, const std::string& name,
                                 const std::string& file, std::size_t plan_count);

/// Prints the summary of results. Exit status 3 if a run did not end well.
options::ExitStatus ShowResult(const std::filesystem::path& out, bool is_quiet);

}  // namespace cdb::plans
