// Files that a user or a file names, opened for reading. Only regular files are: a pipe or a device
// would be waited for, or never end.
//
// Errors: `why` says what is wrong, without the name. Threads: any.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace cdb::plan {

/// More than any plan of listed runs has.
inline constexpr std::size_t kMaxInputBytes = std::size_t{1} << 30;

/// Empty where `path` is a regular file that can be read: for libraries that open files themselves.
std::string WhyNotReadable(const std::string& path);

/// The whole file. Nullopt where it is no regular file, cannot be read or has more than
/// `max_bytes`.
std::optional<std::string> ReadInputFile(const std::string& path, std::string& why,
                                         std::size_t max_bytes = kMaxInputBytes);

/// What is left of an open file, as ReadInputFile: for standard input.
std::optional<std::string> ReadInput(int fd, std::string& why,
                                     std::size_t max_bytes = kMaxInputBytes);

}  // namespace cdb::plan
