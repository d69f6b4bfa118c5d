// What commands say. A reader that has gone is no error: the work goes on.
#pragma once

#include <string>
#include <string_view>

namespace cdb::report {

/// What was asked for: to standard output.
void Print(std::string_view text);
/// Everything else: to standard error.
void Say(std::string_view text);

/// As a shell takes it for one word: in quotes where it must be.
std::string ShellWord(std::string_view text);

}  // namespace cdb::report
