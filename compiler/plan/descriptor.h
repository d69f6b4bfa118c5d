// A file descriptor with an owner.
#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

namespace cdb::plan {

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
