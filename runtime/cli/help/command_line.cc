#include "runtime/cli/help/command_line.h"

#include <CLI/CLI.hpp>

#include "runtime/cli/help/help_commands.h"
#include "runtime/cli/help/topics.h"
#include "runtime/manual/explanation.h"
#include "runtime/manual/lookup.h"

namespace cdb::help {

std::string CommandInfo::Synopsis() const {
  std::string text = "cdb " + name;
  for (const ArgumentInfo& argument : arguments) {
    const std::string shown = argument.name + (argument.is_repeated ? "..." : "");
    text += argument.is_required ? " " + shown : " [" + shown + "]";
  }
  return text;
}

std::vector<CommandInfo> CommandsOf(const CLI::App& app) {
  std::vector<CommandInfo> commands;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_group().empty()) continue;
    CommandInfo info{command->get_name(), command->get_description(), {}, {}};
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

std::vector<std::string> WordsFor(const std::string& command) {
  std::vector<std::string> words;
  if (command == "doc") {
    words = manual::KnownNames();
    for (const std::string_view topic : TopicNames()) words.emplace_back(topic);
  } else if (command == "explain") {
    for (const manual::Explanation* row : manual::AllExplanations())
      words.insert(words.end(), {std::string(row->kind->code), std::string(row->kind->id)});
  } else if (command == "list") {
    words = ListKinds();
  } else if (command == "generate") {
    words = GeneratedKinds();
  }
  return words;
}

}  // namespace cdb::help
