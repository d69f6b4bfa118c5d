// The command line as data, for shell completion and manual pages.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cdb::help {

struct OptionInfo {
  std::vector<std::string> names;  ///< `-o`, `--out`
  std::string help;
  bool takes_value = false;
};

struct ArgumentInfo {
  std::string name, help;
  bool is_required = false, is_repeated = false;
};

struct CommandInfo {
  std::string name, help;
  std::vector<OptionInfo> options;
  std::vector<ArgumentInfo> arguments;

  /// `cdb fmt FILE...`
  std::string Synopsis() const;
};

/// The subcommands that `cdb --help` lists, in its order.
std::vector<CommandInfo> CommandsOf(const CLI::App& app);

/// The words that the argument of a command accepts: names for `cdb doc`, codes for `cdb explain`.
/// Empty if the command takes files.
std::vector<std::string> WordsFor(const std::string& command);

}  // namespace cdb::help
