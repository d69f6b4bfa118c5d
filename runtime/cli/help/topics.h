// The topics of `cdb doc`: the pages of the manual, with their generated parts.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/cli/options/subcommand.h"

namespace cdb::help {

/// The page that lists the topics.
inline constexpr std::string_view kListOfTopics = "README";

std::vector<std::string_view> TopicNames();

/// The page of a topic, fitted to the terminal; empty if there is none of this name.
std::string TopicText(std::string_view name);

/// What a page marks by `<!-- NAME -->`: a table, made from those of the schema. Empty if there is
/// none of this name.
std::string GeneratedPart(std::string_view name);

}  // namespace cdb::help

namespace CLI {
class App;
}

namespace cdb::help {

// The command line as data, for shell completion and manual pages.

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
