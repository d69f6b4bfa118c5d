// What commands say. A reader that has gone is no error: the work goes on.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cdb::report {

/// What was asked for: to standard output.
void Print(std::string_view text);
/// Everything else: to standard error.
void Say(std::string_view text);

/// Columns of the terminal that standard output is: COLUMNS if that is set, else its own; 0 where
/// it is a file or a pipe.
std::size_t TerminalWidth();

/// As a shell takes it for one word: in quotes where it must be.
std::string ShellWord(std::string_view text);

}  // namespace cdb::report
