// The command line of cdb.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <exception>

#include "dsl/diagnostics.h"
#include "runtime/cli/commands.h"
#include "runtime/report/console.h"

namespace {

using namespace cdb;
using namespace cdb::cli;

/// Commands of the design that this version has not got: refused by name.
struct NotYet {
  const char* name;
  const char* what;
};
constexpr NotYet kNotYet[] = {
    {"report", "a page of a results file"},
    {"view", "a scene in the browser"},
    {"submit", "a sweep on a cluster"},
};

int Main(int argc, char** argv) {
  CLI::App app("cdb turns a small language into measured physics: `cdb run FILE.cdb`");
  app.set_version_flag("--version", "cdb " CDB_VERSION);
  app.require_subcommand(1);
  app.fallthrough(false);
  int status = kExitGood;

  std::vector<std::string> files, plugins;
  const auto add_plugins = [&plugins](CLI::App* command) {
    command
        ->add_option("--plugin", plugins,
                     "a shared library with detectors of your own; several: each with --plugin")
        ->allow_extra_args(false);
  };
  auto* check = app.add_subcommand("check", "check scenario files: every error with its place");
  check->add_option("FILE", files, "scenario files")->required();
  add_plugins(check);
  check->callback([&] { status = CheckCommand(files, plugins); });

  PlanArguments plan_arguments;
  std::string plan_benchmark;
  auto* plan = app.add_subcommand("plan", "print the expanded runs of a scenario file");
  plan->add_option("FILE", plan_arguments.file, "scenario file, or a plan")->required();
  plan->add_option("-b,--benchmark", plan_benchmark, "only this benchmark");
  plan->add_option("-o,--out", plan_arguments.out, "write the plan as YAML; - for standard output");
  plan->add_flag("--why", plan_arguments.why,
                 "place the objects of each run, and say what it leaves out and why");
  plan->add_option("--only", plan_arguments.only, "with --why: this one run");
  add_plugins(plan);
  plan->callback([&] {
    plan_arguments.plugins = plugins;
    if (!plan_benchmark.empty()) plan_arguments.benchmark = plan_benchmark;
    status = PlanCommand(plan_arguments);
  });

  RunArguments run_arguments;
  std::string run_benchmark;
  auto* run = app.add_subcommand("run", "run a scenario file or a plan; goes on where it stopped");
  run->add_option("FILE", run_arguments.file, "scenario file, or a plan as YAML")->required();
  run->add_option("-b,--benchmark", run_benchmark, "only this benchmark");
  run->add_option("-o,--out", run_arguments.out,
                  "results file, or a folder for them (default: BENCHMARK.h5)");
  run->add_option("-j,--jobs", run_arguments.jobs, "runs at a time; timings want 1 (default)")
      ->check(CLI::Range(1, 4096));
  run->add_option("--shard", run_arguments.shard,
                  "K/N: only the K-th of N parts; merge them later");
  run->add_option("--only", run_arguments.only,
                  "run this one run by itself, into RUN.h5 (ids: cdb plan)");
  run->add_flag("--fresh", run_arguments.fresh, "forget results and shards and start over");
  run->add_flag("-q,--quiet", run_arguments.quiet, "print nothing but errors");
  add_plugins(run);
  run->callback([&] {
    run_arguments.plugins = plugins;
    if (!run_benchmark.empty()) run_arguments.benchmark = run_benchmark;
    status = RunCommand(run_arguments);
  });

  TraceArguments trace_arguments;
  std::string trace_benchmark;
  auto* trace = app.add_subcommand("trace", "record the boxes of runs for detectors to be run on");
  trace->add_option("FILE", trace_arguments.file, "scenario file, or a plan as YAML")->required();
  trace->add_option("-b,--benchmark", trace_benchmark, "only this benchmark");
  trace->add_option("-o,--out", trace_arguments.out,
                    "trace file, or a folder for them (default: BENCHMARK.trace.h5; of several "
                    "points, the folder BENCHMARK.traces)");
  trace->add_flag("--fresh", trace_arguments.fresh, "write over what is there");
  trace->add_flag("-q,--quiet", trace_arguments.quiet, "print nothing but errors");
  add_plugins(trace);
  trace->callback([&] {
    trace_arguments.plugins = plugins;
    if (!trace_benchmark.empty()) trace_arguments.benchmark = trace_benchmark;
    status = TraceCommand(trace_arguments);
  });

  ShowArguments show_arguments;
  auto* show = app.add_subcommand("show", "a summary of a results file on the terminal");
  show->add_option("FILE", show_arguments.file, "results file")->required();
  show->add_option("--by", show_arguments.by, "axes that make the rows (quantity,detector)")
      ->delimiter(',');
  show->add_option("--error", show_arguments.error,
                   "an error against run time (position, energy: cdb doc accuracy)");
  show->add_option("--each", show_arguments.each,
                   "with --error: axes each value of which has a table and a front of its own")
      ->delimiter(',');
  show->callback([&] { status = ShowCommand(show_arguments); });

  StabilityArguments stability_arguments;
  auto* stability = app.add_subcommand(
      "stability", "run the stability suite and map where each configuration stops being sound");
  stability->add_option("SCENE", stability_arguments.scenes, "scenes of the suite (default: all)");
  stability->add_option("--precision", stability_arguments.precisions, "default: single,double")
      ->delimiter(',');
  stability->add_option("--detector", stability_arguments.detectors, "default: dbvt")
      ->delimiter(',');
  stability->add_option("-o,--out", stability_arguments.out,
                        "folder of the results (default: stability)");
  stability->add_option("-j,--jobs", stability_arguments.jobs, "runs at a time (default: 1)")
      ->check(CLI::Range(1, 4096));
  stability->add_flag("--fresh", stability_arguments.fresh, "forget results and start over");
  stability->add_flag("-q,--quiet", stability_arguments.quiet, "no progress, only the map");
  stability->callback([&] { status = StabilityCommand(stability_arguments); });

  VerifyArguments verify_arguments;
  std::string verify_benchmark;
  std::uint64_t verify_cycles = 0;
  auto* verify = app.add_subcommand(
      "verify", "hold every detector's pairs and contacts against exact ones, in each cycle");
  verify->add_option("FILE", verify_arguments.file, "scenario file, or a plan as YAML")->required();
  verify->add_option("-b,--benchmark", verify_benchmark, "only this benchmark");
  verify
      ->add_option("--detector", verify_arguments.detectors,
                   "these in place of the file's own; all: every one that holds the scene")
      ->delimiter(',');
  verify->add_option("--cycles", verify_cycles, "so many in place of the file's own")
      ->check(CLI::Range(1, 2147483647));
  verify->add_option("-o,--out", verify_arguments.out,
                     "folder of BENCHMARK.verify.h5 (default: the current one)");
  verify->add_option("-j,--jobs", verify_arguments.jobs, "runs at a time (default: 1)")
      ->check(CLI::Range(1, 4096));
  verify->add_flag("--fresh", verify_arguments.fresh, "forget results and start over");
  verify->add_flag("-q,--quiet", verify_arguments.quiet, "no progress, only the table");
  add_plugins(verify);
  verify->callback([&] {
    verify_arguments.plugins = plugins;
    if (!verify_benchmark.empty()) verify_arguments.benchmark = verify_benchmark;
    if (verify_cycles > 0) verify_arguments.cycles = verify_cycles;
    status = VerifyCommand(verify_arguments);
  });

  std::string merged;
  std::vector<std::string> shards;
  auto* merge = app.add_subcommand("merge", "make a results file of shards, as far as they go");
  merge->add_option("-o,--out", merged, "results file")->required();
  merge->add_option("SHARDS", shards, "folders of shards, or shards")->required();
  merge->callback([&] { status = MergeCommand(merged, shards); });

  bool only_check = false;
  auto* fmt_command = app.add_subcommand("fmt", "lay scenario files out in the one standard way");
  fmt_command->add_option("FILE", files, "scenario files")->required();
  fmt_command->add_flag("--check", only_check, "change nothing; exit status 1 if it would");
  fmt_command->callback([&] { status = FormatCommand(files, only_check); });

  std::string topic, kind;
  auto* doc = app.add_subcommand("doc", "the reference: language, parameters, results");
  doc->add_option("NAME", topic, "a topic or a parameter");
  doc->callback([&] { status = DocCommand(topic); });
  auto* list = app.add_subcommand("list", "what a scenario can name");
  list->add_option("KIND", kind, "objects, detectors, layouts, schedules or scenarios");
  list->callback([&] { status = ListCommand(kind); });

  for (const NotYet& command : kNotYet) {
    auto* refused = app.add_subcommand(command.name, fmt::format("{} (not yet)", command.what));
    refused->allow_extras()->callback([&command] {
      throw CommandError(fmt::format("`cdb {}` is not part of this version yet", command.name));
    });
  }

  if (argc > 1 && argv[1][0] != '-') {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    if (std::ranges::find(names, argv[1]) == names.end()) {
      const std::string_view near = cdb::dsl::DidYouMean(argv[1], {names.begin(), names.end()});
      throw CommandError(fmt::format("there is no command '{}'; {}", argv[1],
                                     near.empty() ? std::string("`cdb --help` lists them")
                                                  : fmt::format("did you mean '{}'?", near)));
    }
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitGood : kExitWorld;
  }
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  // A limit on the size of files is an error of the write that meets it, with a message; not our
  // end.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return Main(argc, argv);
  } catch (const std::exception& error) {
    report::Say(fmt::format("cdb: {}\n", error.what()));
  }
  return kExitWorld;
}
