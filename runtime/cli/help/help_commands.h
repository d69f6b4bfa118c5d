// The subcommands that print the reference. See commands.h.
#pragma once

#include <string>
#include <vector>

#include "runtime/cli/options/exit_status.h"

namespace CLI {
class App;
}

namespace cdb::help {

/// `cdb doc`: a topic, a parameter, a word of the language or a scenario.
void AddDocCommand(CLI::App& app, options::ExitStatus& status);
/// `cdb list`: the names that a scenario can use.
void AddListCommand(CLI::App& app, options::ExitStatus& status);
/// `cdb explain`: a kind of diagnostic, with a wrong and a right example.
void AddExplainCommand(CLI::App& app, options::ExitStatus& status);
/// `cdb generate`: files for editors, shells and man, made from the tables of the language.
void AddGenerateCommand(CLI::App& app, options::ExitStatus& status);

/// The words that `cdb list` and `cdb generate` accept as arguments.
std::vector<std::string> ListKinds();
std::vector<std::string> GeneratedKinds();

}  // namespace cdb::help
