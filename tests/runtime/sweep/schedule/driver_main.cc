// A driver for tests that kill it: schedule_test_driver PLAN FOLDER JOBS WORKER [FILE_LIMIT]. Exit
// status as for `cdb run`; prints the summary.
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstdlib>
#include <string>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/sweep/process/worker.h"
#include "runtime/sweep/schedule/progress.h"
#include "runtime/sweep/schedule/schedule.h"
#include "tests/runtime/sweep/schedule/plans.h"

namespace cdb::tests {
namespace {

int Main(int argc, char** argv) {
  if (argc < 5) return 64;
  const plan::Plan plan = yaml::FromYaml(ReadFile(argv[1]), argv[1]);
  process::StopFlag stop;
  const process::StopOnSignals watch(stop);
  schedule::ExecuteOptions options;
  options.folder = argv[2];
  options.jobs = std::strtoul(argv[3], nullptr, 10);
  options.stop = &stop;
  process::ProcessLauncher launcher({argv[4], argv[4]}, options.jobs, &stop);
  if (argc > 5) {
    signal(SIGXFSZ, SIG_IGN);
    const rlim_t bytes = std::strtoul(argv[5], nullptr, 10);
    const rlimit limit = {bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  schedule::Progress progress(schedule::StandardError());
  const schedule::Summary summary = schedule::Execute(plan, options, launcher, progress);
  fmt::print("{}\n", schedule::Describe(summary));
  if (summary.signal != 0) return 128 + summary.signal;
  return summary.HasBadRuns() ? 3 : 0;
}

}  // namespace
}  // namespace cdb::tests

using namespace cdb::tests;

int main(int argc, char** argv) {
  try {
    return Main(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "cdb: {}\n", error.what());
    return 2;
  }
}
