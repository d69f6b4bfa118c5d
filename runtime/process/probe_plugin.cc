#include "runtime/process/probe_plugin.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>

#include "library/detectors/description.h"
#include "runtime/process/process.h"
#include "runtime/process/worker.h"

namespace cdb::process {
namespace {

using Clock = std::chrono::steady_clock;

std::string Contents(const Descriptor& file) {
  std::string bytes;
  char buffer[65536];
  while (true) {
    const ssize_t got = pread(file.get(), buffer, sizeof buffer, static_cast<off_t>(bytes.size()));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) FailToStart("cannot look into a library", errno);
    if (got == 0) return bytes;
    bytes.append(buffer, static_cast<std::size_t>(got));
  }
}

/// False where it has not ended by then.
bool WaitFor(const Descriptor& process, double seconds) {
  const auto until = Clock::now() + std::chrono::duration<double>(seconds);
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
    pollfd watched = {process.get(), POLLIN, 0};
    const int ready = poll(&watched, 1, static_cast<int>(std::max<long>(left.count(), 0)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) FailToStart("cannot wait for a worker", errno);
    if (ready == 0) return false;
  }
}

}  // namespace

std::optional<std::vector<schema::PluginDetector>> ProbePlugin(const std::filesystem::path& worker,
                                                               const std::string& path,
                                                               std::string& why, double seconds) {
  const Descriptor answer = MemoryFile("cdb-describe"), errors = MemoryFile("cdb-describe-errors");
  SpawnPlan spawn;
  spawn.Give(answer.get(), STDOUT_FILENO);
  spawn.Give(errors.get(), STDERR_FILENO);
  const pid_t pid = spawn.Start(worker, {detectors::kDescribeOption, path});
  const bool has_ended = WaitFor(WatchProcess(pid), seconds);
  kill(-pid, SIGKILL);  // and what it left running
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) FailToStart("cannot wait for a worker", errno);
  }
  if (!has_ended) {
    why = fmt::format(
        "'{}' is not loaded after {:g} s: something that it does at loading does not end", path,
        seconds);
    return std::nullopt;
  }
  const std::string text = Contents(answer);
  if (WIFEXITED(status) && WEXITSTATUS(status) == detectors::kNoPlugin && !text.empty()) {
    why = text;
    return std::nullopt;
  }
  if (status == 0)
    if (auto detectors = detectors::ReadDescription(text)) return detectors;
  TextTail tail;
  tail.Append(Contents(errors));
  const std::string lines = tail.LastLines();
  why = fmt::format("'{}' cannot be loaded: the process that tried {}{}{}", path, EndText(status),
                    lines.empty() ? "" : ": ", lines);
  return std::nullopt;
}

}  // namespace cdb::process
