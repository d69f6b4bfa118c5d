// `cdb check`: the errors of scenario files, without running them; whether results files, shards
// and traces are whole.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/grid/part.h"
#include "runtime/cli/check_stored.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/diagnostics_json.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/subcommand.h"
#include "runtime/report/console.h"
#include "runtime/schedule/bounds.h"
#include "runtime/store/store.h"

namespace cdb::cli {
namespace {

struct CheckArguments {
  std::vector<std::string> files;
  std::vector<std::string> plugins;  ///< shared libraries with detectors
  bool json = false;
};

compiler::Compilation CompileToJson(const std::string& file,
                                    const std::vector<std::string>& plugins) {
  compiler::Compilation result =
      CompileWith(FindScenario(file), ReadInput, std::nullopt, plugins, /*lists_runs=*/false);
  report::PrintExact(DiagnosticsJson(result.diagnostics));
  return result;
}

/// Whether this machine can run it, with nothing else at work. Says so where it cannot.
bool FitsHere(const grid::Grid& grid, const std::string& file) {
  plan::Plan plan = grid.head;
  plan.whole =
      std::make_shared<plan::WholePlan>(grid::MakeWhole(std::make_shared<const grid::Grid>(grid)));
  const std::string why =
      schedule::WhyTooLarge(schedule::LeastDemand(plan), schedule::WholeMachine());
  if (!why.empty())
    report::Say(fmt::format("{}: {}: this machine cannot run it: {}\n", file, plan.benchmark, why));
  return why.empty();
}

ExitStatus Check(const CheckArguments& arguments) {
  ExitStatus status = ExitStatus::kGood;
  for (const std::string& name : arguments.files) {
    if (name != "-" && (store::IsStored(name) || name.ends_with(".h5"))) {
      if (arguments.json)
        throw CommandError(fmt::format(
            "--json is for scenario files, and '{}' is none; check it without --json", name));
      status = std::max(status, CheckStored(name));
      continue;
    }
    const std::string file = FileOrStandardInput(name);
    const auto result = arguments.json ? CompileToJson(file, arguments.plugins)
                                       : CompileAndReport(file, std::nullopt, LintText::kWhole,
                                                          arguments.plugins, /*lists_runs=*/false);
    if (result.diagnostics.has_errors()) {
      status = std::max(status, ExitStatus::kScenario);
      continue;
    }
    for (const grid::Grid& grid : result.grids)
      if (!FitsHere(grid, file)) status = std::max(status, ExitStatus::kWorld);
    if (arguments.json) continue;
    for (const grid::Grid& grid : result.grids)
      report::Print(fmt::format("{}: {}: {} {}\n", file, grid.head.benchmark, grid.run_count(),
                                grid.run_count() == 1 ? "run" : "runs"));
  }
  return status;
}

}  // namespace

void AddCheckCommand(CLI::App& app, ExitStatus& status) {
  const auto arguments = std::make_shared<CheckArguments>();
  Subcommand command(
      app, "check",
      "report every error and warning in scenario files; say whether results are whole");
  command.Required("FILE", arguments->files,
                   "scenario files, - for standard input; results files, shards, traces");
  command.Flag("--json", arguments->json,
               "print a JSON object a line for each, with the fields of rustc");
  command.Plugins(arguments->plugins);
  command.Action(status, [arguments] { return Check(*arguments); });
}

}  // namespace cdb::cli
