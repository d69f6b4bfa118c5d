// `cdb generate`: prints files for editors, shells and man, made from the tables of the language.
#include "runtime/cli/help/help_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/cli/help/command_line.h"
#include "runtime/cli/help/man_pages.h"
#include "runtime/cli/help/shell_completion.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/lsp/syntax_files.h"
#include "runtime/terminal/console.h"

namespace cdb::help {
namespace {

using Commands = std::span<const CommandInfo>;

struct GeneratedFile {
  std::string_view kind;
  std::string (*text)(Commands);
};

constexpr GeneratedFile kFiles[] = {
    {"bash", BashCompletion},
    {"zsh", ZshCompletion},
    {"fish", FishCompletion},
    {"cdb.1", ProgramPage},
    {"cdb-language.5", [](Commands) { return LanguagePage(); }},
    {"textmate", [](Commands) { return lsp::TextMateGrammar(); }},
    {"vim", [](Commands) { return lsp::VimSyntax(); }},
    {"vocabulary", [](Commands) { return lsp::VocabularyJson(); }},
};

options::ExitStatus Generate(const CLI::App& app, const std::string& kind) {
  for (const GeneratedFile& file : kFiles) {
    if (file.kind != kind) continue;
    terminal::PrintExact(file.text(CommandsOf(app)));
    return options::ExitStatus::kGood;
  }
  throw options::CommandError(
      fmt::format("there is no file '{}'; there are {}", kind, fmt::join(GeneratedKinds(), ", ")));
}

}  // namespace

std::vector<std::string> GeneratedKinds() {
  std::vector<std::string> kinds;
  for (const GeneratedFile& file : kFiles) kinds.emplace_back(file.kind);
  return kinds;
}

void AddGenerateCommand(CLI::App& app, options::ExitStatus& status) {
  const auto kind = std::make_shared<std::string>();
  options::Subcommand command(app, "generate", "print files for shells, man and editors");
  command.Required("KIND", *kind, fmt::format("{}", fmt::join(GeneratedKinds(), ", ")));
  command.Action(status, [kind, &app] { return Generate(app, *kind); });
}

}  // namespace cdb::help
