// The manual pages, in roff.
#pragma once

#include <span>
#include <string>

#include "runtime/cli/help/topics.h"

namespace cdb::help {

/// cdb.1
std::string ProgramPage(std::span<const CommandInfo> commands);
/// cdb-language.5
std::string LanguagePage();

// Completion of the command line in shells.

std::string BashCompletion(std::span<const CommandInfo> commands);
std::string ZshCompletion(std::span<const CommandInfo> commands);
std::string FishCompletion(std::span<const CommandInfo> commands);

}  // namespace cdb::help
