// The worker: one process for one run. `cdb run` starts it with three descriptors
// (runtime/protocol/recording.h), or has it forked by a waiting fork server
// (runtime/protocol/fork_server.h). It reads the run, writes the recording and ends. Exit status: 0
// if the recording has the outcome of the run, 2 if it could not be written.

#include <LinearMath/btScalar.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/plan/clock.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/layouts/pose_table.h"
#include "runtime/engine/detection/plugin_detectors.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/worker/memory_shortage.h"
#include "runtime/engine/worker/replay.h"
#include "runtime/engine/worker/run_configurations.h"
#include "runtime/engine/worker/run_scene.h"
#include "runtime/engine/worker/run_soft.h"
#include "runtime/engine/worker/settle.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/protocol/fork_server.h"

namespace cdb::worker {
namespace {

constexpr int kCannotReport = 2;

/// The name by which this program was started.
const char* g_program = "";

/// The poses that came with the run. Read from the start each time, because another process of the
/// same run may have read them before.
std::string ReadPackedPoses() {
  std::string packed;
  char buffer[65536];
  for (;;) {
    const ssize_t count =
        pread(protocol::kPosesFd, buffer, sizeof buffer, static_cast<off_t>(packed.size()));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return packed;
    packed.append(buffer, static_cast<std::size_t>(count));
  }
}

bool HasDescriptors() {
  for (const int fd : {protocol::kRunFd, protocol::kRecordingFd, protocol::kContactsFd})
    if (fcntl(fd, F_GETFD) < 0) return false;
  return true;
}

/// Makes the runner start the same run again, with all walls, in a new process.
void AskToStartAgain(protocol::Recording& recording, const world::OmissionGuardTripped& tripped) {
  recording.header().message = tripped.what();
  recording.header().outcome.store(protocol::WorkerOutcome::kAgain, std::memory_order_release);
}

void RunScenario(const plan::Run& run, protocol::Recording& recording, Streams streams,
                 const Kept& kept) {
  auto engine = RunScene(run, recording, streams, kept);
  // The C library detects writes beyond a plug-in's memory when that memory is freed.
  if (!run.scene.plugins.empty()) return;
  static_cast<void>(engine.release());  // the system frees it
}

struct CannotCount : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Makes instructions the clock of this process. Throws CannotCount.
void CountInstructions(const plan::Scene& scene) {
  if (scene.world.Count("threads") > 1)
    throw CannotCount(
        "clock instructions: only runs with one thread can be counted; set `threads 1`");
  try {
    world::CountInstructions(protocol::kCountsFd);
  } catch (const std::runtime_error& error) {
    throw CannotCount(error.what());
  }
}

/// Throws CannotCount if the clock failed in a run that would otherwise be done.
void RequireCounts(const protocol::Recording& recording) {
  if (recording.header().outcome.load() != protocol::WorkerOutcome::kDone) return;
  try {
    world::RequireCounts();
  } catch (const std::runtime_error& error) {
    throw CannotCount(error.what());
  }
}

void RunWorker(Streams streams, const Kept& kept) {
  const plan::Run run = yaml::RunFromYaml(protocol::ReadAll(protocol::kRunFd), "run");
  protocol::Recording recording = protocol::Recording::Open(protocol::kRecordingFd, run.scene);
  const detection::NotesPluginCalls notes(recording.header().plugin_call);
  const NotesMemoryShortage shortage(recording.header().is_out_of_memory);
  const std::string mismatch = world::PrecisionMismatch();
  if (!mismatch.empty()) {
    ReportFailure(recording, mismatch);
  } else if (run.scene.world.WordOr("precision") != world::EnginePrecision()) {
    ReportFailure(recording,
                  fmt::format("the run needs {} precision, but this worker has {}",
                              run.scene.world.WordOr("precision"), world::EnginePrecision()));
  } else {
    try {
      if (plan::CountsInstructions(run.scene)) CountInstructions(run.scene);
      if (run.scene.world.Lists("record", "counters")) world::CountEvents();
      if (analysis::HasConfigurations(run.scene)) {
        RunConfigurations(run, recording, streams);
      } else if (analysis::HasSoft(run.scene)) {
        RunSoft(run, recording);
      } else if (analysis::TraceOf(run.scene)) {
        ReplayTrace(run, recording, protocol::kTraceFd);
      } else {
        RunScenario(run, recording, streams, kept);
      }
      RequireCounts(recording);
    } catch (const world::OmissionGuardTripped& tripped) {
      AskToStartAgain(recording, tripped);
    } catch (const CannotCount& cannot) {
      ReportFailure(recording, cannot.what());
    }
  }
  // For a run that did not get that far.
  if (std::isnan(recording.header().scalars.peak_rss_bytes))
    recording.header().scalars.peak_rss_bytes = probes::PeakRssBytes();
}

/// Executes the command given by its arguments, without the program; returns the exit status.
int Execute(const std::vector<std::string>& given) {
  std::vector<std::string> arguments = given;
  Streams streams = {.contacts_fd = protocol::kContactsFd};
  if (!arguments.empty() && arguments[0] == protocol::kNarrowInputOption) {
    streams.narrow_input_fd = protocol::kNarrowInputFd;
    arguments.erase(arguments.begin());
  }
  const std::string option = arguments.empty() ? "" : arguments[0];
  const bool settles = arguments.size() == 1 && option == kSettleOption;
  const bool keeps = arguments.size() == 3 && option == protocol::kKeepOption;
  if (!settles && ((!arguments.empty() && !keeps) || !HasDescriptors())) {
    fmt::print(stderr,
               "{}: this program executes one run of a plan for `cdb run`; do not start it by "
               "hand: use `cdb run FILE.cdb`\n",
               g_program);
    return kCannotReport;
  }
  try {
    protocol::BindToRunner();
    layouts::SetPoseReader(
        [](const schema::Call& poses) { return layouts::UnpackPoses(ReadPackedPoses(), poses); });
    if (settles) {
      SettleForAnother(yaml::RunFromYaml(protocol::ReadAll(STDIN_FILENO), "run"), STDOUT_FILENO);
    } else {
      RunWorker(streams, keeps ? Kept{arguments[1], arguments[2]} : Kept{});
    }
    std::fflush(nullptr);
    _exit(0);  // skips destructors: the system frees everything
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", g_program, error.what());
    return kCannotReport;
  }
}

}  // namespace
}  // namespace cdb::worker

int main(int argc, char** argv) {
  using namespace cdb;
  worker::g_program = argv[0];
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments == std::vector<std::string>{"--version"}) {
    fmt::print("cdb {}, Bullet {}.{}, {} precision\n", CDB_VERSION, btGetVersion() / 100,
               btGetVersion() % 100, world::EnginePrecision());
    return 0;
  }
  const bool serves = arguments == std::vector<std::string>{protocol::kServeOption};
  if (serves && fcntl(protocol::kServerFd, F_GETFD) >= 0) protocol::ServeForks(worker::Execute);
  return worker::Execute(arguments);
}
