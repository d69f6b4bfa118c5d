// `cdb stability`: runs the stability suite of the library and prints where simulation stops being
// sound.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/compile.h"
#include "dsl/diagnostics.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/plan_runner.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct StabilityArguments {
  std::vector<std::string> scenes;  ///< of the suite; empty: all
  std::vector<std::string> precisions = {"single", "double"}, detectors = {"dbvt"};
  std::vector<std::string> narrow_phases;  ///< empty: those of the scenes
  std::string out = "stability";           ///< folder of the results
  std::uint64_t jobs = 1;
  bool has_boundaries = false;  ///< search them, instead of running the grids
  bool fresh = false;
  bool quiet = false;

  /// The folder of its scenarios in the library.
  const char* suite() const { return has_boundaries ? "boundaries" : "stability"; }
};

std::vector<std::string> SuiteFiles(const StabilityArguments& arguments) {
  const fs::path folder = fs::path(options::ScenarioLibrary()) / arguments.suite();
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".cdb") names.push_back(entry.path().stem());
  if (names.empty())
    throw options::CommandError(
        "the stability suite is not installed beside this program; install cdb");
  std::ranges::sort(names);
  return names;
}

/// The requested scenes of the suite; all if none was requested.
std::vector<std::string> Choose(const StabilityArguments& arguments) {
  const auto names = SuiteFiles(arguments);
  if (arguments.scenes.empty()) return names;
  for (const std::string& name : arguments.scenes) {
    if (std::ranges::find(names, name) != names.end()) continue;
    throw options::CommandError(
        fmt::format("the stability suite has no '{}'; {}", name,
                    options::Suggestion(name, {names.begin(), names.end()},
                                        fmt::format("it has {}", fmt::join(names, ", ")))));
  }
  return arguments.scenes;
}

options::ExitStatus RunSuite(const StabilityArguments& arguments) {
  options::CheckWords("precision", arguments.precisions);
  options::CheckWords("detector", arguments.detectors);
  options::CheckWords("narrow_phase", arguments.narrow_phases);
  std::vector<plan::Plan> plans;
  for (const std::string& name : Choose(arguments)) {
    const std::string file = fmt::format("{}/{}", arguments.suite(), name);
    // No lints: these scenarios use such numbers on purpose.
    const auto loaded = options::LoadPlans(file, {}, options::LintText::kNone);
    if (loaded.empty()) return options::ExitStatus::kScenarioError;
    for (plan::Plan plan : loaded) {
      if (!arguments.narrow_phases.empty())
        plan = compiler::Cross(plan, "narrow_phase", arguments.narrow_phases);
      plan = compiler::Cross(plan, "detector", arguments.detectors);
      plans.push_back(compiler::Cross(plan, "precision", arguments.precisions));
    }
  }
  plans::MakeResultsFolder(arguments.out);
  const plans::PlanRunner runner({arguments.jobs, arguments.fresh, arguments.quiet});
  for (const plan::Plan& plan : plans) {
    const fs::path out = fs::path(arguments.out) / (plan.benchmark + ".h5");
    if (runner.Execute(plan, out).summary.signal != 0) return runner.StoppedStatus();
    const results::ResultFile file(out);
    terminal::Print(
        (arguments.has_boundaries ? printers::BoundariesText(file) : printers::StabilityMap(file)) +
        "\n");
  }
  return options::ExitStatus::kGood;
}

void DeclareStability(options::Subcommand& command) {
  const auto arguments = std::make_shared<StabilityArguments>();
  command.Optional("SCENE", arguments->scenes, "scenes of the suite (default: all)");
  command.List("--precision", arguments->precisions, "precisions (default: single,double)");
  command.List("--detector", arguments->detectors, "detectors (default: dbvt)");
  command.List("--narrow-phase", arguments->narrow_phases,
               "narrow phases (default: that of each scene)");
  command.Out(arguments->out, "folder for the results (default: stability)");
  command.Jobs(arguments->jobs, "number of parallel runs (default: 1)");
  command.Flag("--boundaries", arguments->has_boundaries,
               "search where each scene stops being sound, to 5 % and over five seeds");
  command.Fresh(arguments->fresh, "discard results and start over");
  command.Quiet(arguments->quiet, "print only the map, without progress");
  command.Action([arguments] { return RunSuite(*arguments); });
}

}  // namespace

/// Runs the suite and prints the map. Safe to rerun: finished runs are skipped. Failed runs are
/// expected here: exit status 0.
options::Command StabilityCommand() {
  return {.name = "stability",
          .help = "run the stability suite, and map where each configuration stops being sound",
          .declare = DeclareStability};
}

}  // namespace cdb::cli
