// `cdb verify`: every detector's pairs against brute force, in every cycle of a scenario.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan_yaml.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/plan_runner.h"
#include "runtime/cli/subcommand.h"
#include "runtime/cli/verify_plan.h"
#include "runtime/report/console.h"
#include "runtime/report/verify_table.h"
#include "runtime/store/safe_file.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct VerifyArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::vector<std::string> detectors;   ///< empty: the file's own; `all`: every one that can
  std::optional<std::uint64_t> cycles;  ///< nullopt: the file's own
  std::vector<std::string> plugins;     ///< shared libraries with detectors
  std::string out;                      ///< folder of the results; empty: the current one
  std::uint64_t jobs = 1;
  bool fresh = false;
  bool quiet = false;
};

/// Beside the results, so that one run of them can be seen by itself.
void WritePlan(const plan::Plan& plan, const fs::path& path) {
  store::WriteWhole(plan::ToYaml(plan), path);
}

ExitStatus Verify(const VerifyArguments& arguments) {
  VerifyOptions options = {arguments.detectors, arguments.cycles, {}};
  const auto plans = LoadPlans(arguments.file, arguments.benchmark, LintText::kNone,
                               arguments.plugins, &options.plugins);
  if (plans.empty()) return ExitStatus::kScenario;
  if (!options.WantsAll()) CheckWords("detector", options.detectors, options.plugins);
  std::vector<VerifyPlan> verified;
  for (const plan::Plan& plan : plans) verified.push_back(MakeVerifyPlan(plan, options));
  const fs::path folder = arguments.out;
  if (!folder.empty()) MakeResultsFolder(folder);
  const PlanRunner runner({arguments.jobs, arguments.fresh, arguments.quiet});
  ExitStatus status = ExitStatus::kGood;
  for (VerifyPlan& one : verified) {
    const std::string name = (folder / one.plan.benchmark).string();
    const std::string plan_file = name + ".verify.yaml";
    const fs::path out = name + ".verify.h5";
    one.plan.source = plan_file;
    if (runner.Execute(one.plan, out).summary.signal != 0) return runner.StoppedStatus();
    WritePlan(one.plan, plan_file);
    const report::VerifyText text = report::VerifyTable(store::ResultFile(out), one.left_out);
    report::Print(text.text + "\n");
    if (!text.is_good) status = ExitStatus::kRuns;
  }
  return status;
}

}  // namespace

void AddVerifyCommand(CLI::App& app, ExitStatus& status) {
  const auto arguments = std::make_shared<VerifyArguments>();
  Subcommand command(app, "verify",
                     "compare every detector's pairs and contacts with exact ones, in each cycle");
  command.Required("FILE", arguments->file, "scenario file, or a plan as YAML");
  command.Benchmark(arguments->benchmark);
  command.List("--detector", arguments->detectors,
               "these in place of the file's own; all: every one that holds the scene");
  command.Cycles(arguments->cycles, "so many in place of the file's own");
  command.Out(arguments->out, "folder of BENCHMARK.verify.h5 (default: the current one)");
  command.Jobs(arguments->jobs, "runs at a time (default: 1)");
  command.Fresh(arguments->fresh, "forget results and start over");
  command.Quiet(arguments->quiet, "no progress, only the table");
  command.Plugins(arguments->plugins);
  command.Action(status, [arguments] { return Verify(*arguments); });
}

}  // namespace cdb::cli
