// The worker: one process for one run. `cdb run` starts it with three descriptors
// (runtime/measure/recording.h); it reads the run, writes the recording and ends.
// Exit status: 0 when the recording says how the run ended, 2 when that was not possible.

#include <LinearMath/btScalar.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <system_error>

#include "compiler/plan_yaml.h"
#include "compiler/trace.h"
#include "library/detectors/description.h"
#include "library/detectors/plugin.h"
#include "runtime/engine/memory.h"
#include "runtime/engine/plugin_detectors.h"
#include "runtime/engine/precision.h"
#include "runtime/engine/replay.h"
#include "runtime/engine/run_scene.h"
#include "runtime/engine/settle.h"
#include "runtime/engine/whole_files.h"

namespace cdb::runtime {
namespace {

constexpr int kCannotReport = 2;
/// Followed by the reason; a worker gives it to itself.
constexpr const char* kKeepWalls = "--keep-walls";

bool HasDescriptors() {
  for (const int fd : {kRunFd, kRecordingFd, kContactsFd})
    if (fcntl(fd, F_GETFD) < 0) return false;
  return true;
}

/// The same run from the start in a process that has done nothing yet, with all walls.
[[noreturn]] void StartAgain(const char* program, Recording& recording, const Tripped& tripped) {
  recording.Clear();
  if (lseek(kRunFd, 0, SEEK_SET) != 0 || ftruncate(kContactsFd, 0) != 0 ||
      lseek(kContactsFd, 0, SEEK_SET) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot start again");
  execl("/proc/self/exe", program, kKeepWalls, tripped.what(), nullptr);
  throw std::system_error(errno, std::generic_category(), "cannot start again");
}

/// What a library offers, for `cdb` (kDescribeOption). The library may print what it likes, or
/// without end.
int DescribeLibrary(const std::string& path) {
  const int out = dup(STDOUT_FILENO);
  constexpr rlimit kLimit = {1 << 20, 1 << 20};
  if (out < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0 || setrlimit(RLIMIT_FSIZE, &kLimit) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot look into a library");
  try {
    WriteAll(out, library::DescriptionOf(library::LoadPlugin(path)));
    return 0;
  } catch (const library::PluginError& error) {
    WriteAll(out, error.what());
    return library::kNoPlugin;
  }
}

void RunWorker(const char* program, const std::string& keep_walls) {
  const compiler::Run run = compiler::RunFromYaml(ReadAll(kRunFd), "run");
  Recording recording = Recording::Open(kRecordingFd, run.scene);
  const NotesPluginCalls notes(recording.header().plugin_call);
  const std::string mismatch = PrecisionMismatch();
  if (!mismatch.empty()) {
    ReportFailure(recording, mismatch);
  } else if (run.scene.world.WordOr("precision") != EnginePrecision()) {
    ReportFailure(recording, fmt::format("the run asks for {} precision, this worker has {}",
                                         run.scene.world.WordOr("precision"), EnginePrecision()));
  } else {
    try {
      if (compiler::TraceOf(run.scene)) {
        ReplayTrace(run, recording, kTraceFd);
      } else {
        RunScene(run, recording, kContactsFd, keep_walls).release();  // the system takes it down
      }
    } catch (const Tripped& tripped) {
      StartAgain(program, recording, tripped);
    }
  }
  // Where the run did not get that far.
  if (std::isnan(recording.header().peak_rss_bytes))
    recording.header().peak_rss_bytes = PeakRssBytes();
}

}  // namespace
}  // namespace cdb::runtime

int main(int argc, char** argv) {
  using namespace cdb::runtime;
  if (argc == 2 && std::string_view(argv[1]) == "--version") {
    fmt::print("cdb {}, Bullet {}.{}, {} precision\n", CDB_VERSION, btGetVersion() / 100,
               btGetVersion() % 100, EnginePrecision());
    return 0;
  }
  const bool describes = argc == 3 && std::string_view(argv[1]) == cdb::library::kDescribeOption;
  const bool settles = argc == 2 && std::string_view(argv[1]) == kSettleOption;
  const bool keeps_walls = argc == 3 && std::string_view(argv[1]) == kKeepWalls;
  if (!describes && !settles && ((argc != 1 && !keeps_walls) || !HasDescriptors())) {
    fmt::print(stderr,
               "{}: this program runs one run of a plan for `cdb run` and is not started by hand; "
               "use `cdb run FILE.cdb`\n",
               argv[0]);
    return kCannotReport;
  }
  try {
    // A runner that is killed must not leave workers behind.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (describes) {
      _exit(DescribeLibrary(argv[2]));
    } else if (settles) {
      SettleForAnother(cdb::compiler::RunFromYaml(ReadAll(STDIN_FILENO), "run"), STDOUT_FILENO);
    } else {
      RunWorker(argv[0], keeps_walls ? argv[2] : "");
    }
    std::fflush(nullptr);
    _exit(0);  // nothing left to take down that the system does not
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", argv[0], error.what());
    return kCannotReport;
  }
}
