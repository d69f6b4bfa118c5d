#include "runtime/cli/help/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace cdb::help {

std::string CommandInfo::Synopsis() const {
  std::string text = "cdb " + name;
  for (const ArgumentInfo& argument : arguments) {
    const std::string shown = argument.name + (argument.is_repeated ? "..." : "");
    text += argument.is_required ? " " + shown : " [" + shown + "]";
  }
  return text;
}

std::vector<CommandInfo> CommandsOf(const CLI::App& app, std::span<const options::Command> rows) {
  std::vector<CommandInfo> commands;
  for (const CLI::App* command : app.get_subcommands({})) {
    CommandInfo info{command->get_name(), command->get_description(), {}, {}, {}};
    const auto row = std::ranges::find(rows, info.name, &options::Command::name);
    if (row->words != nullptr) info.words = row->words();
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_positional()) {
        info.arguments.push_back({option->get_name(true, false), option->get_description(),
                                  option->get_required(), option->get_expected_max() > 1});
        continue;
      }
      OptionInfo one{{}, option->get_description(), option->get_items_expected_max() > 0};
      for (const std::string& name : option->get_snames()) one.names.push_back("-" + name);
      for (const std::string& name : option->get_lnames()) one.names.push_back("--" + name);
      info.options.push_back(std::move(one));
    }
    commands.push_back(std::move(info));
  }
  return commands;
}

}  // namespace cdb::help
