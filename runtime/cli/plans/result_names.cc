#include "runtime/cli/plans/result_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <ranges>
#include <system_error>
#include <vector>

#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/sized_plan.h"
#include "runtime/cli/plans/sweep_files.h"
#include "runtime/results/store.h"
#include "runtime/terminal/console.h"

namespace cdb::plans {
namespace {

namespace fs = std::filesystem;

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

/// Results, or an unfinished sweep, of the scenario `file`.
bool IsOfScenario(const fs::path& out, const std::string& file) {
  if (Exists(out) && results::IsStored(out))
    return fs::path(results::ResultFile(out, results::ProofOf::kStructure).source()).filename() ==
           fs::path(file).filename();
  return !FindPlanIn(RunsFolderOf(out)).empty();
}

/// `FILE.h5`, or `NAME.h5` if an earlier cdb has written that.
fs::path NameAfterFile(const fs::path& folder, const std::string& name, const std::string& file) {
  const fs::path out = folder / (fs::path(options::FindScenarioFile(file)).stem().string() + ".h5");
  const fs::path earlier = folder / (name + ".h5");
  if (out == earlier || Exists(out) || Exists(RunsFolderOf(out)) || !IsOfScenario(earlier, file))
    return out;
  terminal::Say(
      fmt::format("the results of {} are in '{}': earlier versions of cdb named them "
                  "after the benchmark; rename them to '{}' if you like\n",
                  file, earlier.string(), out.string()));
  return earlier;
}

fs::path NameIn(const fs::path& folder, const std::string& name, const std::string& file) {
  return !file.empty() && !options::IsPlanFile(file) && options::BenchmarksOf(file).size() == 1
             ? NameAfterFile(folder, name, file)
             : folder / (name + ".h5");
}

/// Throws CommandError that says how to make the results of a scenario.
[[noreturn]] void RefuseMissing(const std::string& file, const std::vector<fs::path>& outs) {
  for (const fs::path& out : outs)
    if (const fs::path folder = RunsFolderOf(out); !FindPlanIn(folder).empty())
      throw options::CommandError(
          fmt::format("'{0}' is not there yet, only an unfinished sweep, '{1}': `cdb run {2}` "
                      "resumes it, `cdb merge -o {0} {1}` makes results of its finished runs",
                      out.string(), folder.string(), terminal::ShellWord(file)));
  throw options::CommandError(fmt::format("{} has no results here ('{}'): `cdb run {}` makes them",
                                          file, outs.front().string(), terminal::ShellWord(file)));
}

std::string FindResultOfScenario(const std::string& file) {
  std::vector<fs::path> outs, there;
  for (const std::string& name : options::BenchmarksOf(file))
    outs.push_back(NameIn("", name, file));
  if (outs.empty())
    throw options::CommandError(
        fmt::format("{} has no benchmark, and so no results; `cdb check {}` explains", file,
                    terminal::ShellWord(file)));
  std::ranges::copy_if(outs, std::back_inserter(there), Exists);
  if (there.size() > 1)
    throw options::CommandError(fmt::format(
        "{} has several results: {}; name one of them", file,
        fmt::join(there | std::views::transform([](const fs::path& each) { return each.string(); }),
                  ", ")));
  if (there.empty()) RefuseMissing(file, outs);
  return there.front().string();
}

}  // namespace

fs::path ResultPath(const std::string& out, const std::string& name, const std::string& file,
                    std::size_t plan_count) {
  std::error_code error;
  if (out.empty()) return RequireOwnFolder(NameIn("", name, file));
  if (fs::path(out).extension() == ".runs")
    throw options::CommandError(fmt::format(
        "'{}': names that end in .runs are folders of unfinished sweeps; name another file by -o",
        out));
  if (fs::is_directory(out, error) || out.ends_with('/'))
    return RequireOwnFolder(NameIn(out, name, file));
  if (plan_count > 1)
    throw options::CommandError(
        fmt::format("{} has {} benchmarks, but '{}' can hold only one: name a folder, such as "
                    "'{}/', or choose a benchmark by -b",
                    file, plan_count, out, fs::path(out).replace_extension().string()));
  const fs::path folder = fs::path(out).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error))
    throw options::CommandError(
        fmt::format("the folder '{}' of '{}' does not exist; make it first", folder.string(), out));
  return RequireOwnFolder(out);
}

std::string FindResult(const std::string& name) {
  if (name.ends_with(".cdb")) return FindResultOfScenario(name);
  if (Exists(name) || !name.ends_with(".h5")) return name;
  const fs::path scenario = fs::path(name).filename().replace_extension(".cdb");
  if (Exists(scenario)) return FindResultOfScenario(scenario.string());
  if (!FindPlanIn(RunsFolderOf(name)).empty())
    throw options::CommandError(fmt::format(
        "'{0}' is not there yet, only an unfinished sweep: `cdb merge -o {0} {1}` makes "
        "results of its finished runs",
        name, RunsFolderOf(name).string()));
  return name;
}

}  // namespace cdb::plans
