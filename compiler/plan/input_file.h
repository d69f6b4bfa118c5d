// Opens files named by a user or a file, for reading. Only regular files: a pipe or a device might
// block, or never end.
//
// Errors: `why` is the reason, without the name of the file. Threads: any.
#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace cdb::plan {

/// More than the size of any plan that lists its runs.
inline constexpr std::size_t kMaxInputBytes = std::size_t{1} << 30;

/// Empty if `path` is a readable regular file, otherwise the reason: for libraries that open files
/// themselves.
std::string WhyNotReadable(const std::string& path);

/// Reads a whole file. Nullopt if it is not a regular file, cannot be read or has more than
/// `max_bytes`.
std::optional<std::string> ReadInputFile(const std::string& path, std::string& why,
                                         std::size_t max_bytes = kMaxInputBytes);

/// Reads the rest of an open file, as ReadInputFile: for standard input.
std::optional<std::string> ReadInput(int fd, std::string& why,
                                     std::size_t max_bytes = kMaxInputBytes);

// SHA-256 (FIPS 180-4), to identify plans and runs by their contents.

/// 64 hex digits.
std::string Sha256Hex(std::string_view data);
/// The same without special processor instructions.
std::string PortableSha256Hex(std::string_view data);

// A file descriptor with an owner.

/// Closed by the destructor. A negative number means none.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() { Close(); }
  /// 0, or the errno; a failed write may be reported only on closing (NFS, quotas).
  int Close() { return fd_ >= 0 && close(std::exchange(fd_, -1)) != 0 ? errno : 0; }
  int get() const { return fd_; }

 private:
  int fd_;
};

/// Whether the open file is the one at `path`, which may be a symbolic link to it.
inline bool IsAt(int fd, const std::filesystem::path& path) {
  struct stat ours = {}, there = {};
  return fstat(fd, &ours) == 0 && stat(path.c_str(), &there) == 0 && ours.st_ino == there.st_ino &&
         ours.st_dev == there.st_dev;
}

}  // namespace cdb::plan
