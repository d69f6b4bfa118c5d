// A driver for the tests that end it: schedule_test_driver PLAN FOLDER JOBS WORKER [FILE_LIMIT].
// Exit status as `cdb run`; the summary goes to standard output.
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstdlib>
#include <string>

#include "compiler/plan_yaml.h"
#include "runtime/schedule/progress.h"
#include "runtime/schedule/schedule.h"
#include "runtime/schedule/worker.h"
#include "tests/runtime/schedule/plans.h"

namespace cdb::runtime {
namespace {

int Main(int argc, char** argv) {
  if (argc < 5) return 64;
  const compiler::Plan plan = compiler::FromYaml(test::ReadText(argv[1]), argv[1]);
  StopFlag stop;
  const StopOnSignals watch(stop);
  ExecuteOptions options;
  options.folder = argv[2];
  options.jobs = std::strtoul(argv[3], nullptr, 10);
  options.stop = &stop;
  ProcessLauncher launcher({argv[4], argv[4]}, options.jobs, &stop);
  if (argc > 5) {
    signal(SIGXFSZ, SIG_IGN);
    const rlim_t bytes = std::strtoul(argv[5], nullptr, 10);
    const rlimit limit = {bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  Progress progress(StandardError());
  const Summary summary = Execute(plan, options, launcher, progress);
  fmt::print("{}\n", Describe(summary));
  if (summary.signal != 0) return 128 + summary.signal;
  return summary.HasBadRuns() ? 3 : 0;
}

}  // namespace
}  // namespace cdb::runtime

int main(int argc, char** argv) {
  try {
    return cdb::runtime::Main(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "cdb: {}\n", error.what());
    return 2;
  }
}
