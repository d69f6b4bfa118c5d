#include "library/meshes/import.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>
#include <vector>

#include "compiler/plan/input_file.h"
#include "dsl/text/utf8.h"
#include "library/meshes/mesh_formats.h"
#include "library/sanitizers.h"
#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

namespace fs = std::filesystem;
using plan::Descriptor;

constexpr const char* kConvert = "export it again, or as OBJ, PLY or STL";

/// A line of the importer, which may be damaged.
std::string Shown(std::string_view line) {
  constexpr std::size_t kMostText = 500;
  return text::Printable(line.substr(0, kMostText));
}

[[noreturn]] void FailToStart(std::string_view name, int error) {
  throw library::SceneError(fmt::format("{}: cannot start the importer of this format: {}", name,
                                        std::generic_category().message(error)),
                            error == ENOENT ? "install cdb again, with cdb-import"
                                            : "close other programs and try again");
}

/// A file in memory, to be read from its start.
Descriptor MemoryFileOf(std::string_view bytes, std::string_view name) {
  Descriptor file(memfd_create("cdb-import", MFD_CLOEXEC));
  if (file.get() < 0) FailToStart(name, errno);
  while (!bytes.empty()) {
    const ssize_t count = write(file.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) FailToStart(name, errno);
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  if (lseek(file.get(), 0, SEEK_SET) != 0) FailToStart(name, errno);
  return file;
}

void Limit(pid_t pid, decltype(RLIMIT_CPU) resource, std::uint64_t value) {
  rlimit limit = {};
  prlimit(pid, resource, nullptr, &limit);
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, value);
  // Above the soft limit, so that the signal tells which limit was reached.
  limit.rlim_max = std::min<rlim_t>(limit.rlim_max, value + 1);
  prlimit(pid, resource, &limit, nullptr);
}

/// Starts the program with these descriptors as standard input and output, and no others. The
/// limits are set at once: until then, it cannot have read much of the file.
pid_t Start(const fs::path& program, const std::string& extension, int input, int output,
            const ImportLimits& limits, std::string_view name) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  // Messages of libraries that crash are not meant for users.
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  sigset_t signals;
  sigemptyset(&signals);
  posix_spawnattr_setsigmask(&attributes, &signals);
  sigfillset(&signals);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::string path = program.string(), word = extension;
  char* const arguments[] = {path.data(), word.data(), nullptr};
  char* const environment[] = {nullptr};
  pid_t pid = -1;
  const int error = posix_spawn(&pid, path.c_str(), &actions, &attributes, arguments, environment);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) FailToStart(name, error);
  Limit(pid, RLIMIT_CORE, 0);
  Limit(pid, RLIMIT_FSIZE, 0);
  Limit(pid, RLIMIT_CPU, limits.cpu_s);
  if (!library::kReservesAddresses) Limit(pid, RLIMIT_AS, limits.memory_bytes);
  return pid;
}

enum class Ending { kWhole, kTooLong, kTooLarge };

using Clock = std::chrono::steady_clock;

/// False if that takes until `end`.
bool WaitUntilReadable(int fd, Clock::time_point end) {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    pollfd ready = {fd, POLLIN, 0};
    const int count = poll(&ready, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    if (count > 0) return true;
    if (count == 0 || errno != EINTR) return false;
  }
}

/// Reads until the process has closed its output and ended.
Ending ReadAnswer(pid_t pid, int fd, const ImportLimits& limits, std::string& answer) {
  const auto end = Clock::now() + std::chrono::seconds(limits.wall_s);
  std::vector<char> piece(1 << 16);
  for (;;) {
    if (!WaitUntilReadable(fd, end)) return Ending::kTooLong;
    const ssize_t n = read(fd, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    answer.append(piece.data(), static_cast<std::size_t>(n));
    if (answer.size() > limits.mesh_bytes) return Ending::kTooLarge;
  }
  // Called by number, because the header of glibc 2.36 lacks its extern "C".
  const Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
  return process.get() < 0 || WaitUntilReadable(process.get(), end) ? Ending::kWhole
                                                                    : Ending::kTooLong;
}

/// Throws if the importer returned no mesh.
void CheckAnswer(Ending ending, int status, const std::string& answer, const ImportLimits& limits,
                 std::string_view name) {
  const auto refuse = [&](const std::string& cause, const std::string& remedy) {
    throw library::SceneError(fmt::format("{}: {}", name, cause), remedy);
  };
  if (ending == Ending::kTooLarge) refuse("its mesh is too large", "simplify the model first");
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (signal == SIGXCPU || ending == Ending::kTooLong)
    refuse(fmt::format("reading it takes longer than the {} s that such a file needs at most",
                       limits.cpu_s),
           kConvert);
  if (signal == SIGKILL)
    refuse("the importer was ended by the system, often because of a lack of memory",
           "close other programs and try again");
  if (signal != 0) refuse(fmt::format("assimp crashes on it ({})", sigdescr_np(signal)), kConvert);
  if (WEXITSTATUS(status) == 0) return;
  // The cause and, on the next line, the remedy.
  Lines lines(answer);
  const std::string cause = lines.Next() ? Shown(lines.line()) : "";
  const std::string remedy = lines.Next() ? Shown(lines.line()) : "";
  refuse(cause.empty() ? "the importer failed without a reason" : cause,
         remedy.empty() ? kConvert : remedy);
}

/// The comment of the header: the parts of the file that are not in the mesh.
std::string CommentOf(std::string_view ply) {
  constexpr std::string_view kComment = "comment ";
  Lines lines(ply);
  while (lines.Next() && lines.line() != "end_header")
    if (lines.line().starts_with(kComment)) return Shown(lines.line().substr(kComment.size()));
  return {};
}

}  // namespace

ImportLimits LimitsForImport(std::uint64_t bytes) {
  constexpr std::uint64_t kBytesInASecond = 1 << 20, kMemoryForAByte = 40;
  ImportLimits limits;
  limits.cpu_s += bytes / kBytesInASecond;
  limits.wall_s += 10 * (bytes / kBytesInASecond);
  limits.memory_bytes += kMemoryForAByte * bytes;
  return limits;
}

fs::path ImporterProgram() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path() / "cdb-import";
}

Mesh ImportMesh(std::string_view bytes, std::string_view name, const fs::path& program) {
  return ImportMesh(bytes, name, program, LimitsForImport(bytes.size()));
}

Mesh ImportMesh(std::string_view bytes, std::string_view name, const fs::path& program,
                const ImportLimits& limits) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) FailToStart(name, errno);
  Descriptor from(ends[0]), to(ends[1]);
  const Descriptor file = MemoryFileOf(bytes, name);
  const std::string extension = LowerCase(fs::path(name).extension().string());
  const pid_t pid = Start(program, extension, file.get(), to.get(), limits, name);
  to.Close();
  std::string answer;
  const Ending ending = ReadAnswer(pid, from.get(), limits, answer);
  if (ending != Ending::kWhole) kill(pid, SIGKILL);
  from.Close();
  int status = 0;
  while (waitpid(pid, &status, 0) < 0)
    if (errno != EINTR) FailToStart(name, errno);
  CheckAnswer(ending, status, answer, limits, name);
  Mesh mesh = ParsePly(answer, name);
  mesh.left_out = CommentOf(answer);
  return mesh;
}

}  // namespace cdb::meshes
