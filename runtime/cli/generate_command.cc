// `cdb generate`: files for editors, shells and man, made from the tables of the language.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/cli/commands.h"
#include "runtime/cli/subcommand.h"
#include "runtime/lsp/syntax_files.h"
#include "runtime/report/console.h"

namespace cdb::cli {
namespace {

struct GeneratedFile {
  std::string_view kind;
  std::string (*text)();
};

constexpr GeneratedFile kFiles[] = {
    {"textmate", lsp::TextMateGrammar},
    {"vim", lsp::VimSyntax},
    {"vocabulary", lsp::VocabularyJson},
};

ExitStatus Generate(const std::string& kind) {
  std::vector<std::string_view> kinds;
  for (const GeneratedFile& file : kFiles) {
    if (file.kind == kind) {
      report::Print(file.text());
      return ExitStatus::kGood;
    }
    kinds.push_back(file.kind);
  }
  throw CommandError(
      fmt::format("there is no file '{}'; there are {}", kind, fmt::join(kinds, ", ")));
}

}  // namespace

void AddGenerateCommand(CLI::App& app, ExitStatus& status) {
  const auto kind = std::make_shared<std::string>();
  Subcommand command(app, "generate", "files for editors, shells and man");
  command.Required("KIND", *kind, "textmate, vim or vocabulary (words of the language as JSON)");
  command.Action(status, [kind] { return Generate(*kind); });
}

}  // namespace cdb::cli
