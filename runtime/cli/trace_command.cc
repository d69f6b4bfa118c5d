// `cdb trace`: the boxes of runs, recorded for detectors to be run on.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "compiler/plan/plan_yaml.h"
#include "compiler/plan/trace.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/subcommand.h"
#include "runtime/process/stop.h"
#include "runtime/process/worker.h"
#include "runtime/report/console.h"
#include "runtime/schedule/schedule.h"
#include "runtime/store/trace_file.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct TraceArguments {
  std::string file;
  std::optional<std::string> benchmark;
  /// A file for one point, a folder for several; empty: named after the benchmark.
  std::string out;
  std::vector<std::string> plugins;  ///< shared libraries with detectors
  bool fresh = false;
  bool quiet = false;
};

/// The plan with each point once, recording what a trace holds and nothing else.
plan::Plan TracePlan(plan::Plan plan) {
  std::erase_if(plan.runs, [](const plan::Run& run) { return run.rep > 0; });
  plan.repeats = 1;
  for (plan::Run& run : plan.runs) {
    if (plan::TraceOf(run.scene))
      throw CommandError(
          fmt::format("{}: {} runs on a trace already; trace a benchmark of a live world",
                      plan.benchmark, plan::Describe(plan, run)));
    const auto set = [&](schema::WorldParameter parameter, schema::Value value) {
      run.scene.world.Set(parameter, std::move(value));
    };
    set("record", schema::WordList{"boxes", "poses"});
    set("pair_order", schema::Word{"sorted"});
    set("accuracy.metrics", schema::WordList{"none"});
    set("repeats", std::uint64_t{1});
    run.id = plan::RunId(run.scene, 0);
  }
  plan.references.clear();
  return plan;
}

/// `crowd`, `crowd_n-1000_detector-dbvt`: a point's name as a file can have it.
std::string FileName(const plan::Plan& plan, const plan::Run& run) {
  std::string name = plan.benchmark;
  for (std::size_t i = 0; i < plan.axes.size(); ++i) {
    const plan::Coordinate& value = plan.axes[i].values[run.at[i]];
    const auto* number = std::get_if<double>(&value);
    name += fmt::format("_{}-{}", plan.axes[i].name,
                        number ? schema::FormatReal(*number) : std::get<std::string>(value));
  }
  for (char& c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '+';
    if (!is_plain) c = '_';
  }
  return name;
}

/// A file for each run, each another.
std::vector<fs::path> FilesOf(const plan::Plan& plan, const TraceArguments& arguments,
                              std::size_t plan_count) {
  std::error_code error;
  const bool is_one = plan.runs.size() == 1 && plan_count == 1;
  if (is_one && !arguments.out.empty() && !fs::is_directory(arguments.out, error))
    return {arguments.out};
  fs::path folder = arguments.out;
  if (folder.empty()) folder = plan.runs.size() == 1 ? "." : plan.benchmark + ".traces";
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error))
    throw CommandError(
        fmt::format("cannot make the folder '{}' for the traces: {}; choose another "
                    "place by -o",
                    folder.string(), error ? error.message() : "a file is there"));
  std::vector<fs::path> files;
  std::set<std::string> taken;
  for (const plan::Run& run : plan.runs) {
    std::string name = FileName(plan, run);
    if (!taken.insert(name).second) name += "_" + run.id;
    fs::path file = folder / (name + ".trace.h5");
    files.push_back(arguments.out.empty() && plan.runs.size() == 1 ? file.lexically_normal()
                                                                   : std::move(file));
  }
  return files;
}

/// Bodies without a filter were never in the world: walls that the run left out.
std::vector<std::size_t> BodiesOf(const measure::Recording& recording) {
  const auto filters = recording.Reals("box_filters");
  std::vector<std::size_t> bodies;
  for (std::size_t i = 0; i < filters.size() / measure::kFilterSize; ++i)
    if (!std::isnan(filters[i * measure::kFilterSize])) bodies.push_back(i);
  return bodies;
}

measure::TraceMemory MemoryOf(const plan::Run& run, const measure::Recording& recording) {
  const std::vector<std::size_t> bodies = BodiesOf(recording);
  if (bodies.empty()) throw CommandError("there is no body in it, so there is nothing to trace");
  const std::uint64_t cycles = run.scene.world.Count("cycles");
  const bool is_double = run.scene.world.WordOr("precision") == "double";
  const auto filters = recording.Reals("box_filters"), boxes = recording.Reals("boxes");
  const std::size_t all = filters.size() / measure::kFilterSize;
  measure::TraceMemory trace = measure::TraceMemory::Create({bodies.size(), cycles, is_double});
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double* filter = &filters[bodies[i] * measure::kFilterSize];
    trace.filters()[i] = {static_cast<std::uint32_t>(filter[0]),
                          static_cast<std::uint32_t>(filter[1]),
                          static_cast<std::uint32_t>(filter[2])};
  }
  std::vector<double> sides(trace.shape().PerCycle());
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const auto box =
          boxes.subspan((cycle * all + bodies[i]) * measure::kBoxSize, measure::kBoxSize);
      if (std::ranges::any_of(box, [](double side) { return std::isnan(side); }))
        throw CommandError(fmt::format(
            "body {} has no box that is a number in cycle {}: the scene exploded; `cdb run` says "
            "how",
            bodies[i], cycle));
      std::ranges::copy(box, &sides[i * measure::kBoxSize]);
    }
    trace.SetBoxes(cycle, sides);
  }
  return trace;
}

class Tracer {
 public:
  Tracer(const plan::Plan& plan, const TraceArguments& arguments, const process::StopFlag& stop)
      : plan_(plan),
        arguments_(arguments),
        stop_(stop),
        launcher_(process::FindWorkers(plan), 1, &stop) {}

  /// ExitStatus::kRuns for a failed run, of which there is no file.
  ExitStatus Trace(const plan::Run& run, const fs::path& file) {
    if (!arguments_.fresh && store::TracedRun(file) == run.id) {
      Tell(file, "is there already; --fresh makes it anew");
      return ExitStatus::kGood;
    }
    CheckIsOurs(file);
    launcher_.Start(0, run);
    std::optional<process::Ending> ending;
    while (!ending && !stop_.requested()) ending = launcher_.Wait(1);
    if (!ending) return ExitStatus::kGood;  // whoever asked to stop sees to the status
    if (ending->result.status != store::Status::kDone) {
      report::Say(fmt::format("{}: {}: {}\n", plan::Describe(plan_, run),
                              store::StatusName(ending->result.status), ending->result.message));
      return ExitStatus::kRuns;
    }
    const measure::TraceMemory trace = MemoryOf(run, *ending->recording);
    const store::TraceOrigin origin = {plan_.benchmark,
                                       plan_.axes.empty() ? "" : plan::Describe(plan_, run),
                                       run.id,
                                       ending->result.state_hash,
                                       run.scene.world.Real("timestep"),
                                       plan_.scenario_text,
                                       plan::RunToYaml(run)};
    store::WriteTrace(trace, origin, run.scene.ObjectCount(), ending->recording->Reals("poses"),
                      file);
    Tell(file, fmt::format("{} bodies, {} cycles; {:.1f} s", trace.shape().bodies,
                           trace.shape().cycles, ending->wall_s));
    return ExitStatus::kGood;
  }

 private:
  void Tell(const fs::path& file, const std::string& what) const {
    if (!arguments_.quiet) report::Print(fmt::format("{}: {}\n", file.string(), what));
  }

  /// What is written over is a trace, or asked for.
  void CheckIsOurs(const fs::path& file) const {
    std::error_code error;
    if (!arguments_.fresh && fs::exists(file, error))
      throw CommandError(
          fmt::format("'{}' is there and is no trace of this run; name another place "
                      "by -o, or say --fresh to write over it",
                      file.string()));
  }

  const plan::Plan& plan_;
  const TraceArguments& arguments_;
  const process::StopFlag& stop_;
  process::ProcessLauncher launcher_;
};

ExitStatus TracePlans(const TraceArguments& arguments) {
  auto plans = LoadPlans(arguments.file, arguments.benchmark,
                         arguments.quiet ? LintText::kNone : LintText::kOneLine, arguments.plugins);
  if (plans.empty()) return ExitStatus::kScenario;
  process::StopFlag stop;
  const process::StopOnSignals signals(stop);
  ExitStatus status = ExitStatus::kGood;
  for (plan::Plan& plan : plans) {
    plan = TracePlan(std::move(plan));
    schedule::CheckMemory(plan);
    const std::vector<fs::path> files = FilesOf(plan, arguments, plans.size());
    Tracer tracer(plan, arguments, stop);
    for (std::size_t i = 0; i < plan.runs.size(); ++i) {
      status = std::max(status, tracer.Trace(plan.runs[i], files[i]));
      if (stop.requested()) return StoppedBy(stop.signal());
    }
  }
  return status;
}

}  // namespace

void AddTraceCommand(CLI::App& app, ExitStatus& status) {
  const auto arguments = std::make_shared<TraceArguments>();
  Subcommand command(app, "trace", "record the boxes of runs for detectors to be run on");
  command.Required("FILE", arguments->file, "scenario file, or a plan as YAML");
  command.Benchmark(arguments->benchmark);
  command.Out(arguments->out,
              "trace file, or a folder for them (default: BENCHMARK.trace.h5; of several "
              "points, the folder BENCHMARK.traces)");
  command.Fresh(arguments->fresh, "write over what is there");
  command.Quiet(arguments->quiet, "print nothing but errors");
  command.Plugins(arguments->plugins);
  command.Action(status, [arguments] { return TracePlans(*arguments); });
}

}  // namespace cdb::cli
