// Runs a program of the system and collects its output.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::cluster {

struct ProgramEnd {
  int status = 0;  ///< exit status; 128 + signal if a signal ended it
  std::string out, err;
};

/// True if PATH has an executable file of that name.
bool IsInPath(const std::string& program);

/// Runs the program `words[0]`, found in PATH, until it ends, with `input` (at most 64 kB) as
/// standard input. It has its own process group, so that Ctrl-C does not reach it. Nullopt if there
/// is no such program. Throws std::system_error if no process can be started.
std::optional<ProgramEnd> RunProgram(const std::vector<std::string>& words,
                                     std::string_view input = {});

}  // namespace cdb::cluster
