// What commands say. A reader that has gone is no error: the work goes on.
#pragma once

#include <string_view>

namespace cdb::runtime {

/// What was asked for: to standard output.
void Print(std::string_view text);
/// Everything else: to standard error.
void Say(std::string_view text);

}  // namespace cdb::runtime
