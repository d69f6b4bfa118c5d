// Starts a program of the system and collects what it prints.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cdb::cluster {

struct ProgramEnd {
  int status = 0;  ///< exit status; 128 + signal where a signal ended it
  std::string out, err;
};

/// There is an executable file of that name.
bool IsInPath(const std::string& program);

/// Runs the program `words[0]`, found in PATH, with `input` (at most 64 kB) as standard input,
/// until it ends. In a process group of its own, so that Ctrl-C does not reach it. Nullopt where
/// there is no such program. Throws std::system_error where no process can be started.
std::optional<ProgramEnd> RunProgram(const std::vector<std::string>& words,
                                     std::string_view input = {});

}  // namespace cdb::cluster
