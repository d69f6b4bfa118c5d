// Programs of the system: finding them, and running them for their output.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::process {

/// The executable file of that name in the first folder of PATH that has one. Threads: any.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

struct ProgramEnd {
  int status = 0;  ///< exit status; 128 + signal if a signal ended it
  std::string out, err;
};

/// The process group of a program that is run.
enum class ProgramGroup {
  kOwn,      ///< Ctrl-C does not reach it, and it cannot read from the terminal
  kCallers,  ///< it may ask for a passphrase at the terminal
};

/// Bytes of the input of a program: what a pipe holds.
inline constexpr std::size_t kMostInput = 1 << 16;

/// Runs the program `words[0]`, found in PATH, until it ends, with `input` (at most kMostInput) as
/// standard input. Nullopt if there is no such program. Throws std::system_error if no process can
/// be started. Threads: one, as it ignores SIGPIPE meanwhile.
std::optional<ProgramEnd> RunProgram(const std::vector<std::string>& words,
                                     std::string_view input = {},
                                     ProgramGroup group = ProgramGroup::kOwn);

/// The last line of a message that is not empty, which names the cause. Threads: any.
std::string LastLine(std::string text);

}  // namespace cdb::process
