#include "runtime/sweep/process/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/protocol/recording.h"
#include "runtime/sweep/process/launcher.h"

extern char** environ;

namespace cdb::process {
namespace {

void Check(int error) {
  if (error != 0) FailToStart("cannot start a run", error);
}

}  // namespace

void FailToStart(std::string_view what, int error) {
  throw ScheduleError(fmt::format("{}: {}", what, std::generic_category().message(error)));
}

Descriptor MemoryFile(const char* name) {
  Descriptor fd(memfd_create(name, MFD_CLOEXEC));
  if (fd.get() < 0) FailToStart("no memory to start a run", errno);
  return fd;
}

Descriptor SealedFile(const char* name, std::string_view content) {
  Descriptor fd(memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (fd.get() < 0 || !protocol::TryWriteAll(fd.get(), std::as_bytes(std::span(content))) ||
      lseek(fd.get(), 0, SEEK_SET) != 0 ||
      fcntl(fd.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE) != 0)
    FailToStart("no memory to start a run", errno);
  return fd;
}

Descriptor WatchProcess(pid_t pid) {
  // Called by number, because the header of glibc 2.36 lacks its extern "C".
  Descriptor fd(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
  if (fd.get() < 0) FailToStart("cannot watch a worker", errno);
  return fd;
}

SpawnPlan::SpawnPlan() {
  posix_spawn_file_actions_init(&actions_);
  posix_spawnattr_init(&attributes_);
  Check(posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0));
  Check(posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0));
}

SpawnPlan::~SpawnPlan() {
  posix_spawnattr_destroy(&attributes_);
  posix_spawn_file_actions_destroy(&actions_);
}

void SpawnPlan::Give(int from, int to) {
  // A source that is also a target would be overwritten before it is copied.
  constexpr int kAboveAllTargets = 16;
  sources_.emplace_back(fcntl(from, F_DUPFD_CLOEXEC, kAboveAllTargets));
  if (sources_.back().get() < 0) FailToStart("no descriptor to start a run", errno);
  Check(posix_spawn_file_actions_adddup2(&actions_, sources_.back().get(), to));
  targets_.push_back(to);
  last_ = std::max(last_, to);
}

std::vector<std::pair<int, int>> SpawnPlan::Given() const {
  std::vector<std::pair<int, int>> given;
  for (std::size_t i = 0; i < sources_.size(); ++i)
    given.emplace_back(sources_[i].get(), targets_[i]);
  return given;
}

pid_t SpawnPlan::Start(const std::filesystem::path& program, std::vector<std::string> arguments) {
  Check(posix_spawn_file_actions_addclosefrom_np(&actions_, last_ + 1));
  sigset_t set;
  sigemptyset(&set);
  Check(posix_spawnattr_setsigmask(&attributes_, &set));
  sigfillset(&set);  // the worker must not inherit signals that we ignore or handle
  Check(posix_spawnattr_setsigdefault(&attributes_, &set));
  Check(posix_spawnattr_setpgroup(&attributes_, 0));
  Check(posix_spawnattr_setflags(
      &attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP));
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  std::vector<char*> environment;
  for (std::string& variable : variables_) environment.push_back(variable.data());
  for (char** variable = environ; *variable != nullptr; ++variable)
    environment.push_back(*variable);
  environment.push_back(nullptr);
  pid_t pid = -1;
  const int error =
      posix_spawn(&pid, program.c_str(), &actions_, &attributes_, words.data(), environment.data());
  if (error != 0) FailToStart(fmt::format("cannot start {}", program.string()), error);
  return pid;
}

void EndOrphans(const std::filesystem::path& program, const std::vector<pid_t>& known) {
  std::ifstream children(fmt::format("/proc/self/task/{}/children", gettid()));
  for (pid_t child = -1; children >> child;) {
    std::error_code error;
    if (std::ranges::find(known, child) != known.end() ||
        !std::filesystem::equivalent(fmt::format("/proc/{}/exe", child), program, error))
      continue;
    kill(child, SIGKILL);
    while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
}

std::string EndText(int wait_status) {
  if (!WIFSIGNALED(wait_status))
    return fmt::format("ended with exit status {}", WEXITSTATUS(wait_status));
  const int signal = WTERMSIG(wait_status);
  const char* name = sigabbrev_np(signal);
  const char* words = sigdescr_np(signal);
  std::string text = fmt::format("was ended by signal {}", signal);
  if (name != nullptr && words != nullptr) text += fmt::format(" (SIG{}, {})", name, words);
  if (signal == SIGKILL) text += ", often because of a lack of memory";
  return text;
}

namespace {

/// Has no descriptor if another process holds the claim.
Descriptor Claim(std::string_view name, int cpu) {
  Descriptor fd(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  const std::string text = fmt::format("{}-{}", name, cpu);
  // After the NUL that marks the abstract namespace.
  const std::size_t size = std::min(text.size(), sizeof address.sun_path - 1);
  std::memcpy(address.sun_path + 1, text.data(), size);
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + size);
  if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), length) != 0) fd.Close();
  return fd;
}

}  // namespace

ClaimedProcessors::ClaimedProcessors(std::size_t slots, std::string_view name) {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0 ||
      static_cast<std::size_t>(CPU_COUNT(&allowed)) < slots)
    return;
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0 && cpus_.size() < slots; --cpu) {
    if (!CPU_ISSET(cpu, &allowed)) continue;
    Descriptor claim = Claim(name, cpu);
    if (claim.get() < 0) continue;
    cpus_.push_back(cpu);
    claims_.push_back(std::move(claim));
  }
  if (cpus_.size() == slots) return;
  cpus_.clear();
  claims_.clear();
}

}  // namespace cdb::process
