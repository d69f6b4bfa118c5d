// The manual pages, in roff.
#pragma once

#include <span>
#include <string>

#include "runtime/cli/help/command_line.h"

namespace cdb::help {

/// cdb.1
std::string ProgramPage(std::span<const CommandInfo> commands);
/// cdb-language.5
std::string LanguagePage();

}  // namespace cdb::help
