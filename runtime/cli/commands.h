// THE table of commands, in the order of `cdb --help`. Shell completion, manual pages and `cdb doc`
// read it. A command is in NAME_command.cc; it throws CommandError, and the errors of the functions
// that it uses.
#pragma once

#include <span>

#include "runtime/cli/options/subcommand.h"

namespace cdb::cli {

std::span<const options::Command> Commands();

}  // namespace cdb::cli
