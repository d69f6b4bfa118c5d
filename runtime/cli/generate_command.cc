// `cdb generate`: files for editors, shells and man, made from the tables of the language.
#include "runtime/cli/generate_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/cli/command_line.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/man_pages.h"
#include "runtime/cli/shell_completion.h"
#include "runtime/cli/subcommand.h"
#include "runtime/lsp/syntax_files.h"
#include "runtime/report/console.h"

namespace cdb::cli {
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

ExitStatus Generate(const CLI::App& app, const std::string& kind) {
  for (const GeneratedFile& file : kFiles) {
    if (file.kind != kind) continue;
    report::PrintExact(file.text(CommandsOf(app)));
    return ExitStatus::kGood;
  }
  throw CommandError(
      fmt::format("there is no file '{}'; there are {}", kind, fmt::join(GeneratedKinds(), ", ")));
}

}  // namespace

std::vector<std::string> GeneratedKinds() {
  std::vector<std::string> kinds;
  for (const GeneratedFile& file : kFiles) kinds.emplace_back(file.kind);
  return kinds;
}

void AddGenerateCommand(CLI::App& app, ExitStatus& status) {
  const auto kind = std::make_shared<std::string>();
  Subcommand command(app, "generate", "files for shells, man and editors");
  command.Required("KIND", *kind, fmt::format("{}", fmt::join(GeneratedKinds(), ", ")));
  command.Action(status, [kind, &app] { return Generate(app, *kind); });
}

}  // namespace cdb::cli
