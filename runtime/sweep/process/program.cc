#include "runtime/sweep/process/program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <span>
#include <sstream>
#include <system_error>

#include "compiler/plan/input_file.h"
#include "runtime/protocol/file_descriptor_io.h"

namespace cdb::process {
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

std::optional<std::filesystem::path> FindProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/bin:/usr/bin");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const std::string program = folder + "/" + name; access(program.c_str(), X_OK) == 0)
      return program;
  return std::nullopt;
}

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

std::string LastLine(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

}  // namespace cdb::process
