// `cdb trace`: records the boxes of runs, and, if asked, their pairs, so that detectors can be run
// on them.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/trace_plan.h"
#include "runtime/protocol/trace_memory.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/trace_file.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/sweep/process/worker.h"
#include "runtime/sweep/schedule/order.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct TraceArguments {
  std::string file;
  std::optional<std::string> benchmark;
  /// A file for one point, a folder for several; empty: named after the benchmark.
  std::string out;
  std::vector<std::string> plugins;   ///< shared libraries with detectors
  std::vector<std::string> settings;  ///< NAME=VALUE, over those of the scenario
  bool pairs = false;                 ///< record the input of narrow phases too
  bool fresh = false;
  bool quiet = false;
};

class Tracer {
 public:
  Tracer(const plan::Plan& plan, const TraceArguments& arguments, const process::StopFlag& stop)
      : plan_(plan),
        arguments_(arguments),
        stop_(stop),
        launcher_(process::FindWorkers(plan), 1, &stop) {
    if (arguments.pairs) launcher_.RecordNarrowInput();
  }

  /// ExitStatus::kFailedRuns for a failed run; no file is written for it.
  options::ExitStatus Trace(const plan::Run& run, const fs::path& file) {
    files::RemoveStaleTemporariesBeside(file);
    if (!arguments_.fresh) {
      const auto traced = results::TracedRun(file);
      if (traced != run.id) {
        CheckIsFree(file);
      } else if (!arguments_.pairs || !results::ReadTraceFacts(file).pairs_sha256.empty()) {
        Tell(file, "exists already; --fresh records it again");
        return options::ExitStatus::kGood;
      }
    }
    launcher_.Start(0, run, "");
    std::optional<process::Ending> ending;
    while (!ending && !stop_.requested()) ending = launcher_.Wait(1);
    if (!ending)
      return options::ExitStatus::kGood;  // the code that requested the stop sets the
                                          // status
    if (ending->result.status != results::Status::kDone) {
      terminal::Say(fmt::format("{}: {}: {}\n", plan::Describe(plan_, run),
                                results::StatusName(ending->result.status),
                                ending->result.message));
      return options::ExitStatus::kFailedRuns;
    }
    const std::string run_text = yaml::RunToYaml(run);
    const protocol::TraceMemory trace =
        arguments_.pairs ? protocol::TraceOfPairs(run.scene, *ending->recording,
                                                  ending->narrow_input.get(), run_text)
                         : protocol::TraceOf(run.scene, *ending->recording);
    const results::TraceOrigin origin = {plan_.benchmark,
                                         plan_.axes.empty() ? "" : plan::Describe(plan_, run),
                                         run.id,
                                         ending->result.state_hash,
                                         run.scene.world.Real("timestep"),
                                         plan_.scenario_text,
                                         run_text};
    results::WriteTrace(trace, origin, run.scene.ObjectCount(), ending->recording->Reals("poses"),
                        file);
    Tell(file,
         fmt::format("{} bodies, {} cycles{}; {:.1f} s", trace.shape().bodies, trace.shape().cycles,
                     arguments_.pairs ? fmt::format(", {} pairs", trace.shape().pairs) : "",
                     ending->wall_s));
    return options::ExitStatus::kGood;
  }

 private:
  void Tell(const fs::path& file, const std::string& what) const {
    if (!arguments_.quiet) terminal::Print(fmt::format("{}: {}\n", file.string(), what));
  }

  /// Throws CommandError if the file exists.
  static void CheckIsFree(const fs::path& file) {
    std::error_code error;
    if (fs::exists(file, error))
      throw options::CommandError(
          fmt::format("'{}' exists but is not a trace of this run; name another place by -o, or "
                      "use --fresh to overwrite it",
                      file.string()));
  }

  const plan::Plan& plan_;
  const TraceArguments& arguments_;
  const process::StopFlag& stop_;
  process::ProcessLauncher launcher_;
};

/// The statements by which a file in this folder runs detectors on the traces: along the numbers
/// that were swept, if there is one axis of them.
std::string StatementsFor(const plan::Plan& plan, const std::vector<fs::path>& files) {
  const auto text_of = [](const fs::path& file) { return fmt::format("\"{}\"", file.string()); };
  std::string traces;
  for (const fs::path& file : files)
    traces += fmt::format("{}{}", traces.empty() ? "" : ", ", text_of(file));
  if (plan.axes.size() != 1 || plan.axes[0].IsText())
    return fmt::format("  trace sweep({})\n", traces);
  std::string numbers;
  for (std::size_t i = 0; i < plan.runs.size(); ++i)
    numbers += fmt::format("{}{}", i == 0 ? "" : ", ",
                           std::get<double>(plan.axes[0].values[plan.runs[i].at[0]]));
  return fmt::format("  let {0}, recorded = zip(sweep({1}), sweep({2}))\n  trace recorded\n",
                     plan.axes[0].name, numbers, traces);
}

options::ExitStatus TracePlans(const TraceArguments& arguments) {
  auto plans = options::LoadPlans(
      arguments.file, arguments.benchmark,
      arguments.quiet ? options::LintText::kNone : options::LintText::kOneLine, arguments.plugins);
  if (plans.empty()) return options::ExitStatus::kScenarioError;
  process::StopFlag stop;
  const process::StopOnSignals signals(stop);
  options::ExitStatus status = options::ExitStatus::kGood;
  for (plan::Plan& plan : plans) {
    plan = plans::MakeTracePlan(std::move(plan));
    schedule::CheckFits(plan.benchmark, schedule::LeastDemand(plan), arguments.out);
    const std::vector<fs::path> files = plans::TraceFiles(plan, arguments.out, plans.size());
    Tracer tracer(plan, arguments, stop);
    for (std::size_t i = 0; i < plan.runs.size(); ++i) {
      status = std::max(status, tracer.Trace(plan.runs[i], files[i]));
      if (stop.requested()) return options::StoppedBy(stop.signal());
    }
    if (!arguments.quiet && files.size() > 1)
      terminal::Print("To run detectors on them, in a benchmark:\n" + StatementsFor(plan, files));
  }
  return status;
}

void DeclareTrace(options::Subcommand& command) {
  const auto arguments = std::make_shared<TraceArguments>();
  command.Required("FILE", arguments->file, "scenario file, or a plan as YAML");
  command.Benchmark(arguments->benchmark);
  command.Out(arguments->out,
              "trace file, or a folder for them (default: BENCHMARK.trace.h5; for several "
              "points, the folder BENCHMARK.traces)");
  command.Flag("--pairs", arguments->pairs,
               "record the poses and pairs too, to time narrow phases on them");
  command.Fresh(arguments->fresh, "overwrite existing traces");
  command.Quiet(arguments->quiet, "print only errors");
  command.Plugins(arguments->plugins);
  command.Set(arguments->settings);
  command.Action([arguments] {
    options::SetInScenario(arguments->file, arguments->benchmark, arguments->settings);
    return TracePlans(*arguments);
  });
}

}  // namespace

/// Runs each point once for its boxes and poses, and writes a trace of each. Safe to rerun:
/// finished traces are skipped, except those without pairs if these are to be recorded.
options::Command TraceCommand() {
  return {.name = "trace",
          .help = "record the boxes of runs, or their pairs too, to time detectors on them later",
          .declare = DeclareTrace};
}

}  // namespace cdb::cli
