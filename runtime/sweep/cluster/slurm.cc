#include "runtime/sweep/cluster/slurm.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "compiler/plan/input_file.h"
#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/sweep/process/find_program.h"

namespace cdb::cluster {
namespace {

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

/// The last line of a message names the cause.
std::string LastLine(std::string_view text) {
  while (text.ends_with('\n')) text.remove_suffix(1);
  const auto begin = text.rfind('\n');
  return std::string(begin == std::string_view::npos ? text : text.substr(begin + 1));
}

[[noreturn]] void FailMissing(const std::string& program) {
  throw std::runtime_error(
      fmt::format("{} is not in PATH: submit sweeps on a login node of the cluster, which has "
                  "Slurm; without Slurm, use GNU parallel or ssh (`cdb doc cluster`)",
                  program));
}

/// The output of a program; nullopt if it is missing or fails.
std::optional<std::string> Ask(const std::vector<std::string>& words) {
  const auto end = RunProgram(words);
  if (!end || end->status != 0) return std::nullopt;
  return end->out;
}

std::uint64_t NumberIn(std::string_view text) {
  std::uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// The tasks that failed, from lines of two fields, `6|FAILED`.
std::map<std::uint64_t, std::string> FailuresIn(const std::string& text) {
  std::map<std::uint64_t, std::string> failures;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto bar = line.find('|');
    if (bar == std::string::npos) continue;
    const auto place = line.rfind('_', bar);  // sacct prints the task as 12_6
    const std::uint64_t task =
        NumberIn(std::string_view(line).substr(place == std::string::npos ? 0 : place + 1));
    const std::string state = line.substr(bar + 1);
    if (task > 0 && !state.starts_with("COMPLETED")) failures[task] = state;
  }
  return failures;
}

}  // namespace

void RequireSlurm() {
  if (!IsInPath("sbatch")) FailMissing("sbatch");
}

std::string Submit(const Job& job) {
  const auto end = RunProgram(job.words, job.script);
  if (!end) FailMissing(job.words[0]);
  // `12` or `12;cluster`
  const std::string id = FirstLine(end->out).substr(0, end->out.find_first_of(";\n"));
  if (end->status == 0 && !id.empty() && id.find_first_not_of("0123456789") == std::string::npos)
    return id;
  throw std::runtime_error(fmt::format(
      "sbatch refuses the job: {}; nothing runs. --dry-run shows what is submitted; partition, "
      "time, account and other options are those of cdb submit",
      end->err.empty() ? fmt::format("exit status {}", end->status) : LastLine(end->err)));
}

void Cancel(const std::string& id) { static_cast<void>(RunProgram({"scancel", id})); }

std::optional<ActiveTasks> FindActive(const std::string& array, const std::string& merge,
                                      std::string& why) {
  // One line for each task; tasks that have ended are not listed.
  const auto end = RunProgram(
      {"squeue", "--noheader", "--array", "--jobs=" + array + "," + merge, "--format=%T|%r"});
  if (!end) FailMissing("squeue");
  ActiveTasks active;
  if (end->status != 0) {
    // Slurm forgets jobs some minutes after their end (MinJobAge).
    if (end->err.find("Invalid job id") != std::string::npos) return active;
    why = LastLine(end->err);
    return std::nullopt;
  }
  std::istringstream lines(end->out);
  for (std::string line; std::getline(lines, line);) {
    const auto bar = line.find('|');
    if (bar == std::string::npos) continue;
    const std::string reason = line.substr(bar + 1);
    if (line.starts_with("PENDING")) {
      ++active.waiting;
      // The merge job always waits for the array.
      if (reason != "Dependency" && reason != "None") active.reason = reason;
    } else {
      ++active.running;
    }
  }
  return active;
}

std::map<std::uint64_t, std::string> FindFailures(const std::string& array) {
  if (const auto told = Ask({"sacct", "--noheader", "--allocations", "--parsable2",
                             "--jobs=" + array, "--format=JobID,State"});
      told && !told->empty())
    return FailuresIn(*told);
  const auto told =
      Ask({"squeue", "--noheader", "--array", "--states=all", "--jobs=" + array, "--format=%K|%T"});
  return told ? FailuresIn(*told) : std::map<std::uint64_t, std::string>();
}

Capacity FindCapacity(const std::string& partition) {
  Capacity capacity;
  std::vector<std::string> words = {"sinfo", "--noheader", "--format=%P|%C"};
  if (!partition.empty()) words.push_back("--partition=" + partition);
  // `bench*|0/2/0/2`: the default partition has a star; numbers are allocated, idle, other and all
  // processors.
  std::istringstream lines(Ask(words).value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const auto bar = line.find('|');
    if (bar == std::string::npos || bar == 0) continue;
    if (partition.empty() && line[bar - 1] != '*') continue;
    capacity.cores += NumberIn(std::string_view(line).substr(line.rfind('/') + 1));
  }
  std::istringstream settings(Ask({"scontrol", "show", "config"}).value_or(""));
  for (std::string line; std::getline(settings, line);)
    if (line.starts_with("MaxArraySize"))
      if (const auto size = NumberIn(std::string_view(line).substr(line.rfind(' ') + 1)); size > 1)
        capacity.most_tasks = size - 1;  // size is one more than the largest index
  return capacity;
}

namespace {

using plan::Descriptor;

struct Pipe {
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
      throw std::system_error(errno, std::generic_category(), "no descriptor to start a program");
    read_end = Descriptor(ends[0]);
    write_end = Descriptor(ends[1]);
  }
  Descriptor read_end, write_end;
};

/// Appends the available data; closes `from` at end of file.
void Drain(Descriptor& from, std::string& text) {
  char buffer[4096];
  const ssize_t got = read(from.get(), buffer, sizeof buffer);
  if (got > 0) {
    text.append(buffer, static_cast<std::size_t>(got));
  } else if (got == 0 || errno != EINTR) {
    from.Close();
  }
}

/// While it lives, writing to a program that has ended is an error and no signal.
class IgnoreBrokenPipes {
 public:
  IgnoreBrokenPipes() : before_(signal(SIGPIPE, SIG_IGN)) {}
  ~IgnoreBrokenPipes() { signal(SIGPIPE, before_); }
  IgnoreBrokenPipes(const IgnoreBrokenPipes&) = delete;
  IgnoreBrokenPipes& operator=(const IgnoreBrokenPipes&) = delete;

 private:
  void (*before_)(int);
};

/// Returns 0 or an error number.
int Spawn(const std::vector<std::string>& words, const Pipe& in, const Pipe& out, const Pipe& err,
          ProgramGroup group, pid_t& pid) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&actions, in.read_end.get(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out.write_end.get(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.write_end.get(), STDERR_FILENO);
  sigset_t all;
  sigfillset(&all);
  posix_spawnattr_setsigdefault(&attributes, &all);
  short flags = POSIX_SPAWN_SETSIGDEF;
  if (group == ProgramGroup::kOwn) flags |= POSIX_SPAWN_SETPGROUP;
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, flags);
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const int error = posix_spawnp(&pid, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

}  // namespace

bool IsInPath(const std::string& program) { return process::FindProgram(program).has_value(); }

std::optional<ProgramEnd> RunProgram(const std::vector<std::string>& words, std::string_view input,
                                     ProgramGroup group) {
  Pipe in, out, err;
  pid_t pid = -1;
  const int error = Spawn(words, in, out, err, group, pid);
  if (error == ENOENT || error == EACCES) return std::nullopt;
  if (error != 0)
    throw std::system_error(error, std::generic_category(), "cannot start " + words[0]);
  in.read_end.Close();
  out.write_end.Close();
  err.write_end.Close();
  // Errors are ignored: a program that does not read its input reports the reason itself.
  const IgnoreBrokenPipes ignore;
  static_cast<void>(protocol::TryWriteAll(in.write_end.get(), std::as_bytes(std::span(input))));
  in.write_end.Close();
  ProgramEnd end;
  while (out.read_end.get() >= 0 || err.read_end.get() >= 0) {
    pollfd watched[] = {{out.read_end.get(), POLLIN, 0}, {err.read_end.get(), POLLIN, 0}};
    if (poll(watched, 2, -1) < 0 && errno != EINTR) break;
    if (watched[0].revents != 0) Drain(out.read_end, end.out);
    if (watched[1].revents != 0) Drain(err.read_end, end.err);
  }
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  end.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return end;
}

}  // namespace cdb::cluster
