// `cdb generate`: prints files for editors, shells and man, made from the tables of the language.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/cli/commands.h"
#include "runtime/cli/help/man_pages.h"
#include "runtime/cli/help/topics.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/editor/syntax_files.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

using Infos = std::span<const help::CommandInfo>;

struct GeneratedFile {
  std::string_view kind;
  std::string (*text)(Infos);
};

constexpr GeneratedFile kFiles[] = {
    {"bash", help::BashCompletion},
    {"zsh", help::ZshCompletion},
    {"fish", help::FishCompletion},
    {"cdb.1", help::ProgramPage},
    {"cdb-language.5", [](Infos) { return help::LanguagePage(); }},
    {"textmate", [](Infos) { return editor::TextMateGrammar(); }},
    {"vim", [](Infos) { return editor::VimSyntax(); }},
    {"vocabulary", [](Infos) { return editor::VocabularyJson(); }},
};

std::vector<std::string> GeneratedKinds() {
  std::vector<std::string> kinds;
  for (const GeneratedFile& file : kFiles) kinds.emplace_back(file.kind);
  return kinds;
}

options::ExitStatus Generate(const CLI::App& app, const std::string& kind) {
  for (const GeneratedFile& file : kFiles) {
    if (file.kind != kind) continue;
    terminal::PrintExact(file.text(help::CommandsOf(app, Commands())));
    return options::ExitStatus::kGood;
  }
  throw options::CommandError(
      fmt::format("there is no file '{}'; there are {}", kind, fmt::join(GeneratedKinds(), ", ")));
}

void DeclareGenerate(options::Subcommand& command) {
  const auto kind = std::make_shared<std::string>();
  command.Required("KIND", *kind, fmt::format("{}", fmt::join(GeneratedKinds(), ", ")));
  command.Action([kind, &app = command.program()] { return Generate(app, *kind); });
}

}  // namespace

options::Command GenerateCommand() {
  return {.name = "generate",
          .help = "print files for shells, man and editors",
          .declare = DeclareGenerate,
          .words = GeneratedKinds};
}

}  // namespace cdb::cli
