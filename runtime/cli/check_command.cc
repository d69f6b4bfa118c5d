// `cdb check`: reports the errors of scenario files without running them, and whether results
// files, journals and traces are intact.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/grid/part.h"
#include "library/robots/reader.h"
#include "runtime/cli/check_stored.h"
#include "runtime/cli/options/diagnostics_json.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/sweep/schedule/order.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

struct CheckArguments {
  std::vector<std::string> files;
  std::vector<std::string> plugins;   ///< shared libraries with detectors
  std::vector<std::string> settings;  ///< NAME=VALUE, over those of the scenario
  bool json = false;
};

compiler::Compilation CompileToJson(const std::string& file,
                                    const std::vector<std::string>& plugins) {
  compiler::Compilation result = options::CompileWith(
      options::FindScenario(file), options::ReadInput, std::nullopt, plugins, /*lists_runs=*/false,
      /*models=*/{});
  terminal::PrintJson(options::DiagnosticsJson(result.diagnostics));
  return result;
}

/// True if this machine could run the grid with no other load. Prints the reason if not.
bool FitsHere(const grid::Grid& grid, const std::string& file) {
  plan::Plan plan = grid.head;
  plan.whole =
      std::make_shared<plan::WholePlan>(grid::MakeWhole(std::make_shared<const grid::Grid>(grid)));
  const std::string why =
      schedule::WhyTooLarge(schedule::LeastDemand(plan), schedule::WholeMachine());
  if (!why.empty())
    terminal::Say(
        fmt::format("{}: {}: this machine cannot run it: {}\n", file, plan.benchmark, why));
  return why.empty();
}

options::ExitStatus CheckRobot(const std::string& file) {
  std::vector<analysis::RobotFault> faults;
  const auto robot = robots::ReadRobot(file, {}, faults);
  for (const analysis::RobotFault& fault : faults)
    terminal::Say(fault.remedy.empty() ? fmt::format("{}\n", fault.cause)
                                       : fmt::format("{}; {}\n", fault.cause, fault.remedy));
  if (!robot) return options::ExitStatus::kScenarioError;
  terminal::Print(robots::SummaryOf(*robot, file));
  const std::vector<std::string> refused = robots::RefusedOf(*robot);
  for (const std::string& why : refused)
    terminal::Say(fmt::format("{}: a scene refuses it: {}\n", file, why));
  return refused.empty() ? options::ExitStatus::kGood : options::ExitStatus::kScenarioError;
}

options::ExitStatus Check(const CheckArguments& arguments) {
  options::ExitStatus status = options::ExitStatus::kGood;
  for (const std::string& name : arguments.files) {
    const bool is_robot = robots::IsRobotFile(name);
    if (is_robot || (name != "-" && IsStored(name))) {
      if (arguments.json)
        throw options::CommandError(fmt::format(
            "--json is for scenario files, but '{}' is not one; check it without --json", name));
      status = std::max(status, is_robot ? CheckRobot(name) : CheckStored(name));
      continue;
    }
    const std::string file = options::FileOrStandardInput(name);
    const auto result =
        arguments.json ? CompileToJson(file, arguments.plugins)
                       : options::CompileAndReport(file, std::nullopt, options::LintText::kWhole,
                                                   arguments.plugins, /*lists_runs=*/false);
    if (result.diagnostics.has_errors()) {
      status = std::max(status, options::ExitStatus::kScenarioError);
      continue;
    }
    for (const grid::Grid& grid : result.grids)
      if (!FitsHere(grid, file)) status = std::max(status, options::ExitStatus::kEnvironmentError);
    if (arguments.json) continue;
    for (const grid::Grid& grid : result.grids)
      terminal::Print(fmt::format("{}: {}: {}\n", file, grid.head.benchmark,
                                  searches::RunsText(grid.head, grid.run_count())));
    for (const std::string& robot : result.scenario->RobotTexts()) terminal::Print(robot);
    for (const std::string& model : result.scenario->ModelTexts())
      terminal::Print(fmt::format("  {}\n", model));
  }
  return status;
}

void DeclareCheck(options::Subcommand& command) {
  const auto arguments = std::make_shared<CheckArguments>();
  command.Required("FILE", arguments->files,
                   "scenario files (- for standard input), results files, journals, traces or "
                   "robots (.urdf, .sdf, "
                   ".xml)");
  command.Flag("--json", arguments->json,
               "print each error and warning as a line of JSON, with the fields of rustc");
  command.Plugins(arguments->plugins);
  command.Set(arguments->settings);
  command.Action([arguments] {
    if (!arguments->settings.empty() && arguments->files.size() > 1)
      throw options::CommandError("--set is for one scenario file at a time");
    options::SetInScenario(arguments->files[0], std::nullopt, arguments->settings);
    return Check(*arguments);
  });
}

}  // namespace

options::Command CheckCommand() {
  return {.name = "check",
          .help = "report every error and warning in scenario files; verify results files",
          .declare = DeclareCheck};
}

}  // namespace cdb::cli
