#include "compiler/plan/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace cdb::plan {
namespace {

std::string ErrorText(int error) { return std::generic_category().message(error); }

std::string WhyNoFile(mode_t mode) {
  if (S_ISREG(mode)) return {};
  if (S_ISDIR(mode)) return "it is a folder";
  if (S_ISFIFO(mode)) return "it is a pipe, not a file";
  if (S_ISSOCK(mode)) return "it is a socket, not a file";
  return "it is a device, not a file";
}

/// The descriptor of a regular file, or -1 and the reason.
int OpenInput(const std::string& path, std::string& why) {
  struct stat status = {};
  // Checked before opening: opening alone rewinds a tape.
  if (stat(path.c_str(), &status) != 0) {
    why = ErrorText(errno);
    return -1;
  }
  if (why = WhyNoFile(status.st_mode); !why.empty()) return -1;
  const int fd = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (fd < 0) {
    why = ErrorText(errno);
    return -1;
  }
  why = fstat(fd, &status) != 0 ? ErrorText(errno) : WhyNoFile(status.st_mode);
  if (why.empty()) return fd;
  close(fd);
  return -1;
}

}  // namespace

std::string WhyNotReadable(const std::string& path) {
  std::string why;
  if (const int fd = OpenInput(path, why); fd >= 0) close(fd);
  return why;
}

std::optional<std::string> ReadInput(int fd, std::string& why, std::size_t max_bytes) {
  std::string bytes;
  char buffer[65536];
  for (;;) {
    const ssize_t count = read(fd, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      why = ErrorText(errno);
      return std::nullopt;
    }
    if (count == 0) return bytes;
    bytes.append(buffer, static_cast<std::size_t>(count));
    if (bytes.size() > max_bytes) {
      why = fmt::format("it has more than {} MiB", max_bytes >> 20);
      return std::nullopt;
    }
  }
}

std::optional<std::string> ReadInputFile(const std::string& path, std::string& why,
                                         std::size_t max_bytes) {
  const int fd = OpenInput(path, why);
  if (fd < 0) return std::nullopt;
  auto bytes = ReadInput(fd, why, max_bytes);
  close(fd);
  return bytes;
}

}  // namespace cdb::plan
