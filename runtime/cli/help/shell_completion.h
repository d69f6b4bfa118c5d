// Completion of the command line in shells.
#pragma once

#include <span>
#include <string>

#include "runtime/cli/help/command_line.h"

namespace cdb::help {

std::string BashCompletion(std::span<const CommandInfo> commands);
std::string ZshCompletion(std::span<const CommandInfo> commands);
std::string FishCompletion(std::span<const CommandInfo> commands);

}  // namespace cdb::help
