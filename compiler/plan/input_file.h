// Opens files named by a user or a file, for reading. Only regular files: a pipe or a device might
// block, or never end.
//
// Errors: `why` is the reason, without the name of the file. Threads: any.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

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

}  // namespace cdb::plan
