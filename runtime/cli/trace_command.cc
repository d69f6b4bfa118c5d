// `cdb trace`: records the boxes of runs, and, if asked, their pairs, so that detectors can be run
// on them; or those of the primitives of a deforming mesh.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "compiler/plan/input_file.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/deforming/mesh_sequence.h"
#include "library/deforming/primitives.h"
#include "library/scene_error.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/trace_plan.h"
#include "runtime/protocol/trace_memory.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/mesh_arrays.h"
#include "runtime/results/trace_file.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/sweep/process/worker.h"
#include "runtime/sweep/schedule/order.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct TraceArguments {
  std::vector<std::string> files;  ///< a scenario, or the frames of a mesh
  std::string primitives;          ///< bodies of a deforming mesh; empty: the file is a scenario
  std::optional<std::string> benchmark;
  /// A file for one point, a folder for several; empty: named after the benchmark.
  std::string out;
  std::vector<std::string> plugins;   ///< shared libraries with detectors
  std::vector<std::string> settings;  ///< NAME=VALUE, over those of the scenario
  bool pairs = false;                 ///< record the input of narrow phases too
  bool fresh = false;
  bool quiet = false;
};

/// Throws CommandError if the file exists.
void CheckIsFree(const fs::path& file) {
  std::error_code error;
  if (fs::exists(file, error))
    throw options::CommandError(
        fmt::format("'{}' exists but is not a trace of this run; name another place by -o, or "
                    "use --fresh to overwrite it",
                    file.string()));
}

void Tell(const TraceArguments& arguments, const fs::path& file, const std::string& what) {
  if (!arguments.quiet) terminal::Print(fmt::format("{}: {}\n", file.string(), what));
}

constexpr const char* kExists = "exists already; --fresh records it again";

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
        Tell(arguments_, file, kExists);
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
    Tell(arguments_, file,
         fmt::format("{} bodies, {} cycles{}; {:.1f} s", trace.shape().bodies, trace.shape().cycles,
                     arguments_.pairs ? fmt::format(", {} pairs", trace.shape().pairs) : "",
                     ending->wall_s));
    return options::ExitStatus::kGood;
  }

 private:
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
      arguments.files[0], arguments.benchmark,
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

/// The first file, with the primitives in place of its extension.
fs::path MeshTraceFile(const TraceArguments& arguments) {
  std::error_code error;
  const std::string name =
      fs::path(arguments.files[0]).stem().string() + "." + arguments.primitives + ".trace.h5";
  if (arguments.out.empty()) return name;
  return fs::is_directory(arguments.out, error) ? fs::path(arguments.out) / name
                                                : fs::path(arguments.out);
}

/// A file of all frames, or one for each.
deforming::MeshSequence ReadFrames(const std::vector<std::string>& files) {
  if (files.size() == 1 && fs::path(files[0]).extension() == ".h5")
    return results::ReadMeshArrays(files[0]);
  return deforming::ReadSequence(std::vector<fs::path>(files.begin(), files.end()));
}

/// Writes the trace of a deforming mesh. Nothing is run.
options::ExitStatus TraceMesh(const TraceArguments& arguments) {
  const auto primitives = deforming::PrimitivesOf(arguments.primitives);
  if (!primitives)
    throw options::CommandError(fmt::format("--primitives {} is none of {}", arguments.primitives,
                                            deforming::PrimitiveWords()));
  if (arguments.pairs || arguments.benchmark || !arguments.settings.empty() ||
      !arguments.plugins.empty())
    throw options::CommandError(
        "--pairs, -b, --set and --plugin are for scenarios; with --primitives, the files are the "
        "frames of a mesh");
  constexpr std::size_t kIdDigits = 16;  // as of a run
  constexpr double kTimestep = 1;        // s; files of meshes have no time
  const auto begin = std::chrono::steady_clock::now();
  const fs::path file = MeshTraceFile(arguments);
  try {
    const deforming::MeshSequence sequence = ReadFrames(arguments.files);
    const std::string id =
        plan::Sha256Hex(arguments.primitives + deforming::Sha256(sequence)).substr(0, kIdDigits);
    if (!arguments.fresh) {
      if (results::TracedRun(file) == id) {
        Tell(arguments, file, kExists);
        return options::ExitStatus::kGood;
      }
      CheckIsFree(file);
    }
    const protocol::TraceMemory trace = protocol::TraceOf(*primitives, sequence);
    const std::string bodies =
        fmt::format("{} of {} vertices", arguments.primitives, sequence.vertices());
    results::WriteTrace(trace,
                        {.benchmark = fs::path(arguments.files[0]).stem().string(),
                         .point = bodies,
                         .run_id = id,
                         .state_hash = "",
                         .timestep_s = kTimestep,
                         .scenario_text = "",
                         .run_text = "",
                         .frame_files = fmt::format("{}", fmt::join(arguments.files, "\n"))},
                        0, {}, file);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    Tell(arguments, file,
         fmt::format("{}, {} bodies, {} cycles; {:.1f} s", bodies, trace.shape().bodies,
                     trace.shape().cycles, took.count()));
  } catch (const library::SceneError& error) {
    throw options::CommandError(error.what());
  }
  return options::ExitStatus::kGood;
}

/// The extensions of files that are frames of a mesh, and no scenario.
bool IsMesh(const std::string& file) {
  const std::string extension = fs::path(file).extension().string();
  return extension == ".ply" || extension == ".obj" || extension == ".off" || extension == ".stl";
}

options::ExitStatus TraceFilesOf(const TraceArguments& arguments) {
  if (!arguments.primitives.empty()) return TraceMesh(arguments);
  if (IsMesh(arguments.files[0]))
    throw options::CommandError(
        fmt::format("'{}' is a mesh, which can be traced as one of the frames of a deforming mesh: "
                    "--primitives {}",
                    arguments.files[0], deforming::PrimitiveWords()));
  if (arguments.files.size() > 1)
    throw options::CommandError(
        fmt::format("'{}' is one file too many: a scenario is traced by itself; the frames of a "
                    "deforming mesh need --primitives {}",
                    arguments.files[1], deforming::PrimitiveWords()));
  options::SetInScenario(arguments.files[0], arguments.benchmark, arguments.settings);
  return TracePlans(arguments);
}

void DeclareTrace(options::Subcommand& command) {
  const auto arguments = std::make_shared<TraceArguments>();
  command.Required(
      "FILE", arguments->files,
      "scenario file, or a plan as YAML; with --primitives, the frames of a mesh (PLY, "
      "OBJ, OFF), in order");
  command.Benchmark(arguments->benchmark);
  command.Out(arguments->out,
              "trace file, or a folder for them (default: BENCHMARK.trace.h5; for several "
              "points, the folder BENCHMARK.traces)");
  command.Flag("--pairs", arguments->pairs,
               "record the poses and pairs too, to time narrow phases on them");
  command.Optional("--primitives", arguments->primitives,
                   fmt::format("the bodies of a deforming mesh: {}", deforming::PrimitiveWords()));
  command.Fresh(arguments->fresh, "overwrite existing traces");
  command.Quiet(arguments->quiet, "print only errors");
  command.Plugins(arguments->plugins);
  command.Set(arguments->settings);
  command.Action([arguments] { return TraceFilesOf(*arguments); });
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
