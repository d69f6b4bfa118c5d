#include "runtime/cli/help/shell_completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>

namespace cdb::help {
namespace {

constexpr std::string_view kHead = "# Completion of cdb; written by `cdb generate`.\n";

/// In single quotes; each character of `special` is preceded by a backslash.
std::string Quoted(std::string_view text, std::string_view special = {}) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      if (special.find(c) != std::string_view::npos) quoted += '\\';
      quoted += c;
    }
  }
  return quoted + "'";
}

/// In fish, a single quote within quotes is escaped.
std::string FishQuoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text)
    quoted += c == '\'' || c == '\\' ? fmt::format("\\{}", c) : std::string(1, c);
  return quoted + "'";
}

std::string OptionsOf(const CommandInfo& command) {
  std::string text;
  for (const OptionInfo& option : command.options)
    for (const std::string& name : option.names) text += (text.empty() ? "" : " ") + name;
  return text;
}

}  // namespace

std::string BashCompletion(std::span<const CommandInfo> commands) {
  std::string names, cases;
  for (const CommandInfo& command : commands) {
    names += (names.empty() ? "" : " ") + command.name;
    cases += fmt::format("    {}) options='{}'", command.name, OptionsOf(command));
    if (!command.words.empty()) cases += fmt::format(" words='{}'", fmt::join(command.words, " "));
    cases += " ;;\n";
  }
  return fmt::format(
      "{}_cdb() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} options= words=\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    COMPREPLY=($(compgen -W '{} --help --version' -- \"$current\"))\n"
      "    return\n"
      "  fi\n"
      "  case ${{COMP_WORDS[1]}} in\n{}  esac\n"
      "  if [[ $current == -* ]]; then\n"
      "    COMPREPLY=($(compgen -W \"$options\" -- \"$current\"))\n"
      "  elif [ -n \"$words\" ]; then\n"
      "    COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
      "  else\n"
      "    compopt -o filenames 2>/dev/null\n"
      "    COMPREPLY=($(compgen -f -- \"$current\"))\n"
      "  fi\n"
      "}}\n"
      "complete -F _cdb cdb\n",
      kHead, names, cases);
}

std::string ZshCompletion(std::span<const CommandInfo> commands) {
  std::string names, cases;
  for (const CommandInfo& command : commands) {
    names += fmt::format("    {}\n", Quoted(command.name + ":" + command.help));
    cases += fmt::format("    {})\n      _arguments", command.name);
    for (const OptionInfo& option : command.options)
      for (const std::string& name : option.names)
        cases += fmt::format(" \\\n        {}{}", Quoted(name + "[") + Quoted(option.help, "[]:"),
                             option.takes_value ? "']:value:_files'" : "']'");
    cases += command.words.empty()
                 ? " \\\n        '*:file:_files' ;;\n"
                 : fmt::format(" \\\n        '*:name:({})' ;;\n", fmt::join(command.words, " "));
  }
  return fmt::format(
      "#compdef cdb\n{}_cdb() {{\n  local -a commands=(\n{}  )\n"
      "  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
      "  shift words\n  (( CURRENT-- ))\n"
      "  case $words[1] in\n{}  esac\n}}\n"
      "if [ \"$funcstack[1]\" = _cdb ]; then\n  _cdb \"$@\"\nelse\n  compdef _cdb cdb\nfi\n",
      kHead, names, cases);
}

std::string FishCompletion(std::span<const CommandInfo> commands) {
  std::string text(kHead);
  for (const CommandInfo& command : commands) {
    text += fmt::format("complete -c cdb -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                        FishQuoted(command.help));
    const std::string here = fmt::format("'__fish_seen_subcommand_from {}'", command.name);
    for (const OptionInfo& option : command.options) {
      text += fmt::format("complete -c cdb -n {}", here);
      for (const std::string& name : option.names)
        text += name.starts_with("--") ? fmt::format(" -l {}", name.substr(2))
                                       : fmt::format(" -s {}", name.substr(1));
      text += fmt::format("{} -d {}\n", option.takes_value ? " -r" : "", FishQuoted(option.help));
    }
    if (!command.words.empty())
      text +=
          fmt::format("complete -c cdb -n {} -f -a '{}'\n", here, fmt::join(command.words, " "));
  }
  return text;
}

}  // namespace cdb::help
