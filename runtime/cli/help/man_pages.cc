#include "runtime/cli/help/man_pages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <string_view>

#include "compiler/schema/language_words.h"
#include "compiler/schema/schema.h"
#include "dsl/text/utf8.h"
#include "runtime/cli/help/topics.h"
#include "runtime/manual/markdown.h"
#include "runtime/manual/page.h"

namespace cdb::help {
namespace {

/// Escapes text for roff, so that no character is taken as an instruction.
std::string Roff(std::string_view text) {
  std::string escaped;
  bool is_line_start = true;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    const text::CodePoint point = text::DecodeUtf8(text, at);
    if (point.bytes > 1) {
      escaped += fmt::format("\\[u{:04X}]", static_cast<std::uint32_t>(point.value));
      at += static_cast<std::size_t>(point.bytes) - 1;
      is_line_start = false;
      continue;
    }
    if (is_line_start && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      escaped += c;
    }
    is_line_start = c == '\n';
  }
  return escaped;
}

std::string Bold(std::string_view text) { return fmt::format("\\fB{}\\fR", Roff(text)); }

std::string Item(const std::string& head, std::string_view text) {
  return fmt::format(".TP\n{}\n{}\n", head, Roff(text));
}

std::string CommandText(const CommandInfo& command) {
  std::string text = fmt::format(".SS {}\n{}.\n", Roff(command.Synopsis()), Roff(command.help));
  for (const ArgumentInfo& argument : command.arguments)
    text += Item(Bold(argument.name), argument.help);
  for (const OptionInfo& option : command.options) {
    std::string names;
    for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + Bold(name);
    text += Item(names + (option.takes_value ? " \\fIVALUE\\fR" : ""), option.help);
  }
  return text;
}

/// A page of the manual.
std::string Sections(std::string_view name) {
  constexpr std::size_t kColumns = 78;
  std::string text;
  for (const manual::Section& section : manual::Sections(manual::PageNamed(name)))
    text +=
        fmt::format(".{} {}\n.nf\n{}.fi\n", section.level > 2 ? "SS" : "SH", Roff(section.heading),
                    Roff(manual::BodyText(section.body, kColumns, GeneratedPart)));
  return text;
}

}  // namespace

std::string ProgramPage(std::span<const CommandInfo> commands) {
  std::string text =
      ".TH CDB 1 \"\" \"cdb " CDB_VERSION
      "\" \"User Commands\"\n"
      ".SH NAME\ncdb \\- benchmark of collision detection\n"
      ".SH SYNOPSIS\n\\fBcdb\\fR \\fICOMMAND\\fR [\\fIARGUMENT\\fR...]\n"
      ".SH DESCRIPTION\n"
      "cdb measures how fast, and how accurately, collision detection runs in scenes that are\n"
      "described in a small language; see\n.BR cdb\\-language (5).\n.SH COMMANDS\n";
  for (const CommandInfo& command : commands) text += CommandText(command);
  text += ".SH EXIT STATUS\n";
  text += Item("0", "success");
  text += Item("1", "an error in the scenario");
  text += Item("2", "environment or usage error: disk, files, command line");
  text += Item("3", "complete, but a run failed or its timings do not count");
  text += Item("4",
               "cdb compare found something that fails (--fail-if, --allow), cdb history something "
               "worse than "
               "--fail-above, or cdb suite --against or --page a result that disagrees");
  text += Item("5", "cdb compare did not compare a benchmark, because its scenes differ");
  text += ".SH ENVIRONMENT\n";
  text += Item(Bold("CDB_CACHE"),
               "the folder of decomposed meshes and settled piles, in place of ~/.cache/cdb");
  text += Item(Bold("NO_COLOR"), "if set, errors have no colours");
  return text +
         ".SH SEE ALSO\n.BR cdb\\-language (5);\n\\fBcdb doc\\fR lists the topics of the "
         "reference.\n";
}

std::string LanguagePage() {
  std::string text = ".TH CDB\\-LANGUAGE 5 \"\" \"cdb " CDB_VERSION
                     "\" \"File Formats\"\n"
                     ".SH NAME\ncdb\\-language \\- the language of scenario files, *.cdb\n";
  for (const char* page : {"language", "objects", "layouts", "schedules"}) text += Sections(page);
  text += ".SH WORDS\n";
  for (const schema::LanguageWord& word : schema::LanguageWords())
    text += Item(Bold(word.syntax), word.doc);
  text += ".SH PARAMETERS\n";
  for (const schema::Parameter& parameter : schema::Schema())
    text += fmt::format(".TP\n{}\n{}.\n.br\nTakes {}. Default: {}{}.\n", Bold(parameter.FullName()),
                        Roff(parameter.doc), Roff(parameter.Takes()), Roff(parameter.DefaultText()),
                        parameter.unit.empty() ? "" : " " + Roff(parameter.UnitText()));
  return text + ".SH SEE ALSO\n.BR cdb (1)\n";
}

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
