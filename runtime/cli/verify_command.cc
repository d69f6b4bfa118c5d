// `cdb verify`: every detector's pairs against brute force, in every cycle of a scenario.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "compiler/plan/plan_yaml.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/plan_runner.h"
#include "runtime/cli/verify_plan.h"
#include "runtime/report/console.h"
#include "runtime/report/verify_table.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

/// Beside the results, so that one run of them can be seen by itself.
void WritePlan(const plan::Plan& plan, const fs::path& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << plan::ToYaml(plan);
  if (!file.flush())
    throw CommandError(
        fmt::format("cannot write '{}'; choose another folder by -o", path.string()));
}

}  // namespace

int VerifyCommand(const VerifyArguments& arguments) {
  VerifyOptions options = {arguments.detectors, arguments.cycles, {}};
  const auto plans = LoadPlans(arguments.file, arguments.benchmark, LintText::kNone,
                               arguments.plugins, &options.plugins);
  if (plans.empty()) return kExitScenario;
  if (!options.WantsAll()) CheckWords("detector", options.detectors, options.plugins);
  std::vector<VerifyPlan> verified;
  for (const plan::Plan& plan : plans) verified.push_back(MakeVerifyPlan(plan, options));
  const fs::path folder = arguments.out;
  std::error_code error;
  if (!folder.empty()) fs::create_directories(folder, error);
  if (error)
    throw CommandError(fmt::format("cannot make the folder '{}': {}; choose another by -o",
                                   folder.string(), error.message()));
  const PlanRunner runner({arguments.jobs, arguments.fresh, arguments.quiet});
  int status = kExitGood;
  for (VerifyPlan& one : verified) {
    const std::string name = (folder / one.plan.benchmark).string();
    const std::string plan_file = name + ".verify.yaml";
    const fs::path out = name + ".verify.h5";
    one.plan.source = plan_file;
    if (runner.CarryOut(one.plan, out).summary.signal != 0) return runner.StoppedStatus();
    WritePlan(one.plan, plan_file);
    const report::VerifyText text = report::VerifyTable(store::ResultFile(out), one.left_out);
    report::Print(text.text + "\n");
    if (!text.is_good) status = kExitRuns;
  }
  return status;
}

}  // namespace cdb::cli
