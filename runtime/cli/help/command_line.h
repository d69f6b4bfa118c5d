// The command line as data, for shell completion and manual pages.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "runtime/cli/options/subcommand.h"

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
  std::vector<std::string> words;  ///< that its argument accepts; empty if it takes files

  /// `cdb fmt FILE...`
  std::string Synopsis() const;
};

/// The subcommands that `cdb --help` lists, in its order.
std::vector<CommandInfo> CommandsOf(const CLI::App& app, std::span<const options::Command> rows);

}  // namespace cdb::help
