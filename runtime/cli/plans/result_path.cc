#include "runtime/cli/plans/result_path.h"

#include <fmt/format.h>

#include <system_error>

#include "runtime/cli/plans/sweep_files.h"
#include "runtime/printers/show.h"
#include "runtime/results/store.h"
#include "runtime/terminal/console.h"

namespace cdb::plans {

namespace fs = std::filesystem;

namespace {

/// `r` and `r.h5` would keep their runs in the same folder; each would merge and remove those of
/// the other.
fs::path RequireOwnFolder(fs::path out) {
  fs::path other = out;
  if (out.extension() == ".h5")
    other.replace_extension();
  else
    other += ".h5";
  if (RunsFolderOf(other) != RunsFolderOf(out) || !results::IsStored(other)) return out;
  throw options::CommandError(fmt::format(
      "'{}' is there, and '{}' would keep its runs in the same folder '{}'; nothing was changed: "
      "name another file by -o",
      other.string(), out.string(), RunsFolderOf(out).string()));
}

}  // namespace

fs::path ResultPath(const std::string& out, const std::string& name, const std::string& file,
                    std::size_t plan_count) {
  std::error_code error;
  if (out.empty()) return RequireOwnFolder(name + ".h5");
  if (fs::path(out).extension() == ".runs")
    throw options::CommandError(fmt::format(
        "'{}': names that end in .runs are folders of unfinished sweeps; name another file by -o",
        out));
  if (fs::is_directory(out, error)) return RequireOwnFolder(fs::path(out) / (name + ".h5"));
  if (plan_count > 1)
    throw options::CommandError(
        fmt::format("{} has {} benchmarks, but '{}' can hold only one: name a folder, or choose a "
                    "benchmark by -b",
                    file, plan_count, out));
  const fs::path folder = fs::path(out).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error))
    throw options::CommandError(
        fmt::format("the folder '{}' of '{}' does not exist; make it first", folder.string(), out));
  return RequireOwnFolder(out);
}

options::ExitStatus ShowResult(const fs::path& out, bool is_quiet) {
  const printers::Printed shown =
      printers::Show(results::ResultFile(out, results::ProofOf::kStructure));
  if (!is_quiet) {
    terminal::Print(fmt::format("{}\n{}\n", shown.text, out.string()));
  } else if (shown.bad_count > 0) {
    terminal::Say(fmt::format("some runs did not end well: `cdb show {}` names them\n",
                              terminal::ShellWord(out.string())));
  }
  return shown.bad_count > 0 ? options::ExitStatus::kFailedRuns : options::ExitStatus::kGood;
}

}  // namespace cdb::plans
