// `cdb verify`: compares the pairs and contacts of every detector with exact ones, in every cycle.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/plan_runner.h"
#include "runtime/cli/plans/verify_plan.h"
#include "runtime/printers/show.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct VerifyArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::vector<std::string> detectors;   ///< empty: those of the file; `all`: every one that can
  std::optional<std::uint64_t> cycles;  ///< nullopt: as in the file
  std::vector<std::string> plugins;     ///< shared libraries with detectors
  std::vector<std::string> settings;    ///< NAME=VALUE, over those of the scenario
  std::string out;                      ///< folder of the results; empty: the current one
  std::uint64_t jobs = 1;
  bool fresh = false;
  bool quiet = false;
};

/// Writes the plan beside the results, so that a single run can be executed from it.
void WritePlan(const plan::Plan& plan, const fs::path& path) {
  files::WriteWhole(yaml::ToYaml(plan), path);
}

options::ExitStatus Verify(const VerifyArguments& arguments) {
  plans::VerifyOptions options = {arguments.detectors, arguments.cycles, {}};
  const auto plans =
      options::LoadPlans(arguments.file, arguments.benchmark, options::LintText::kNone,
                         arguments.plugins, &options.plugins);
  if (plans.empty()) return options::ExitStatus::kScenarioError;
  if (!options.WantsAll()) options::CheckWords("detector", options.detectors, options.plugins);
  std::vector<plans::VerifyPlan> verified;
  for (const plan::Plan& plan : plans) verified.push_back(plans::MakeVerifyPlan(plan, options));
  const fs::path folder = arguments.out;
  if (!folder.empty()) plans::MakeResultsFolder(folder);
  const plans::PlanRunner runner({arguments.jobs, arguments.fresh, arguments.quiet});
  options::ExitStatus status = options::ExitStatus::kGood;
  for (plans::VerifyPlan& one : verified) {
    const std::string name = (folder / one.plan.benchmark).string();
    const std::string plan_file = name + ".verify.yaml";
    const fs::path out = name + ".verify.h5";
    one.plan.source = plan_file;
    if (runner.Execute(one.plan, out).summary.signal != 0) return runner.StoppedStatus();
    WritePlan(one.plan, plan_file);
    const printers::VerifyText text = printers::VerifyTable(results::ResultFile(out), one.left_out);
    terminal::Print(text.text + "\n");
    if (!text.is_good) status = options::ExitStatus::kFailedRuns;
  }
  return status;
}

void DeclareVerify(options::Subcommand& command) {
  const auto arguments = std::make_shared<VerifyArguments>();
  command.Required("FILE", arguments->file, "scenario file, or a plan as YAML");
  command.Benchmark(arguments->benchmark);
  command.List("--detector", arguments->detectors,
               "these detectors instead of those of the file, which must exist too; all: every "
               "detector that can handle the scene");
  command.Cycles(arguments->cycles, "number of cycles, instead of that of the file");
  command.Out(arguments->out, "folder for BENCHMARK.verify.h5 (default: the current one)");
  command.Jobs(arguments->jobs, "number of parallel runs (default: 1)");
  command.Fresh(arguments->fresh, "discard results and start over");
  command.Quiet(arguments->quiet, "print only the table, without progress");
  command.Plugins(arguments->plugins);
  command.Set(arguments->settings);
  command.Action([arguments] {
    options::SetInScenario(arguments->file, arguments->benchmark, arguments->settings);
    return Verify(*arguments);
  });
}

}  // namespace

/// Compares the pairs and contacts of detectors with exact ones in each cycle, and prints a table.
/// Exit status 3 for a pair or contact that a detector misses, or a failed run.
options::Command VerifyCommand() {
  return {.name = "verify",
          .help = "compare the pairs and contacts of every detector with exact ones, in each cycle",
          .declare = DeclareVerify};
}

}  // namespace cdb::cli
