// Reads or writes all of a buffer through a file descriptor. Errors: std::system_error, unless a
// function says otherwise. Threads: any.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

namespace cdb::protocol {

/// Reads to the end of the file.
inline std::string ReadAll(int fd) {
  std::string bytes;
  char buffer[65536];
  for (;;) {
    const ssize_t count = read(fd, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw std::system_error(errno, std::generic_category(), "cannot read");
    if (count == 0) return bytes;
    bytes.append(buffer, static_cast<std::size_t>(count));
  }
}

/// False, with errno set, if writing failed.
inline bool TryWriteAll(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errno = EIO;
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

/// `what`: the message of the error.
inline void WriteAll(int fd, std::span<const std::byte> bytes, const char* what) {
  if (!TryWriteAll(fd, bytes)) throw std::system_error(errno, std::generic_category(), what);
}

inline void WriteAll(int fd, std::string_view text) {
  WriteAll(fd, std::as_bytes(std::span(text)), "cannot write");
}

}  // namespace cdb::protocol
