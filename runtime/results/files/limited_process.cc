#include "runtime/results/files/limited_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <span>
#include <system_error>

#include "library/sanitizers.h"
#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/results/files/errors.h"

namespace cdb::files {
namespace {

std::uint64_t AddressSpace() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return std::uint64_t{pages} * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void SetLimit(decltype(RLIMIT_CPU) resource, std::uint64_t value) {
  rlimit limit = {};
  getrlimit(resource, &limit);
  if (limit.rlim_max != RLIM_INFINITY && limit.rlim_max < value) value = limit.rlim_max;
  limit.rlim_cur = value;
  setrlimit(resource, &limit);
}

/// Runs in the copy. Destructors and exit handlers of this process must not run twice.
[[noreturn]] void Work(const std::function<void()>& work, const WorkLimits& limits, int answer) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU})
    std::signal(signal, SIG_DFL);
  // Ignored in the copy: these signals stop the program between two files, and it then ends the
  // copy.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(signal, SIG_IGN);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Messages of libraries that crash are not meant for users.
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  SetLimit(RLIMIT_CORE, 0);
  SetLimit(RLIMIT_CPU, limits.cpu_s);
  if (!library::kReservesAddresses) SetLimit(RLIMIT_AS, AddressSpace() + limits.memory_bytes);
  std::string why;
  try {
    work();
    _exit(0);
  } catch (const std::bad_alloc&) {
    why = "reading it takes more memory than such a file needs";
  } catch (const std::length_error&) {
    why = "reading it takes more memory than such a file needs";
  } catch (const std::exception& error) {
    why = error.what();
  } catch (...) {
    why = "an unknown error";
  }
  protocol::TryWriteAll(answer, std::as_bytes(std::span(why)));
  _exit(1);
}

/// Reads until the other end is closed or time is up; returns false in the latter case.
bool ReadAnswer(int fd, std::chrono::seconds time, std::string& answer) {
  const auto end = std::chrono::steady_clock::now() + time;
  std::array<char, 4096> piece;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd ready = {fd, POLLIN, 0};
    const int count = poll(&ready, 1, static_cast<int>(left.count()));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return count < 0;
    const ssize_t n = read(fd, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return true;
    answer.append(piece.data(), static_cast<std::size_t>(n));
  }
}

std::string Ending(int status, const WorkLimits& limits, const std::string& answer) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (!answer.empty()) return answer;
  // SIGKILL comes from outside, or from this process on a busy machine: it implies nothing about
  // the file.
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
    throw std::runtime_error(
        "the process that reads a file with limits was ended by the system or took too long; close "
        "other programs and try again");
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    return fmt::format("reading it takes longer than the {} s that such a file needs at most",
                       limits.cpu_s);
  return fmt::format("HDF5 crashes on it ({})",
                     WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "it ended the process");
}

[[noreturn]] void FailToStart(int error) {
  throw std::runtime_error(
      fmt::format("cannot start a process that reads a file with limits: {}; close other programs "
                  "and try again",
                  std::generic_category().message(error)));
}

}  // namespace

WorkLimits LimitsForFile(std::uint64_t bytes) {
  constexpr std::uint64_t kBytesInASecond = 5 << 20;
  WorkLimits limits;
  limits.cpu_s += bytes / kBytesInASecond;
  limits.memory_bytes += 4 * bytes;
  return limits;
}

std::string RunLimited(const std::function<void()>& work, const WorkLimits& limits) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) FailToStart(errno);
  const pid_t child = fork();
  if (child < 0) {
    const int error = errno;
    close(ends[0]);
    close(ends[1]);
    FailToStart(error);
  }
  if (child == 0) {
    close(ends[0]);
    Work(work, limits, ends[1]);
  }
  close(ends[1]);
  std::string answer;
  // On a busy machine, a second of processor time takes many seconds.
  if (!ReadAnswer(ends[0], std::chrono::seconds(60 + 10 * limits.cpu_s), answer))
    kill(child, SIGKILL);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) FailToStart(errno);
  return Ending(status, limits, answer);
}

}  // namespace cdb::files
