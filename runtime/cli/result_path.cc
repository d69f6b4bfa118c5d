#include "runtime/cli/result_path.h"

#include <fmt/format.h>

#include <system_error>

#include "runtime/report/console.h"
#include "runtime/report/show.h"
#include "runtime/store/store.h"

namespace cdb::cli {

namespace fs = std::filesystem;

fs::path ResultPath(const std::string& out, const std::string& name, const std::string& file,
                    std::size_t plan_count) {
  std::error_code error;
  if (out.empty()) return name + ".h5";
  if (fs::path(out).extension() == ".runs")
    throw CommandError(fmt::format(
        "'{}': names that end in .runs are folders of shards; name another file by -o", out));
  if (fs::is_directory(out, error)) return fs::path(out) / (name + ".h5");
  if (plan_count > 1)
    throw CommandError(fmt::format(
        "{} has {} benchmarks and '{}' holds one: name a folder, or choose a benchmark by -b", file,
        plan_count, out));
  const fs::path folder = fs::path(out).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error))
    throw CommandError(
        fmt::format("there is no folder '{}' for '{}'; make it first", folder.string(), out));
  return out;
}

ExitStatus ShowResult(const fs::path& out, bool is_quiet) {
  const report::ShowText shown = report::Show(store::ResultFile(out));
  if (!is_quiet) {
    report::Print(fmt::format("{}\n{}\n", shown.text, out.string()));
  } else if (shown.bad_cells > 0) {
    report::Say(fmt::format("not every run ended well: `cdb show {}` names those that did not\n",
                            report::ShellWord(out.string())));
  }
  return shown.bad_cells > 0 ? ExitStatus::kRuns : ExitStatus::kGood;
}

}  // namespace cdb::cli
