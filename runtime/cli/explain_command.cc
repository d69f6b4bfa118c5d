// `cdb explain`: explains a kind of error or warning, with a wrong and a right example, and
// verdicts, with their causes and remedies.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/manual/explanation.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

/// The output of `cdb check` for the wrong example.
std::string RenderedWrong(const manual::Explanation& explanation) {
  const auto read = [&](const std::string& path, std::string& why) -> std::optional<std::string> {
    if (path == "wrong.cdb") return std::string(explanation.wrong);
    if (auto text = manual::ExampleFile(path)) return text;
    why = "No such file or directory";
    return std::nullopt;
  };
  compiler::CompileOptions compile = options::OptionsOf(options::ScenarioLibrary(), {}, {}, true);
  compile.read_model = manual::ExampleModel;
  return dsl::Render(compiler::Compile("wrong.cdb", read, compile).diagnostics,
                     options::RenderOptionsForTerminal());
}

std::vector<std::string> CodesAndNames() {
  std::vector<std::string> names;
  for (const manual::Explanation* row : manual::AllExplanations())
    names.insert(names.end(), {std::string(row->kind->code), std::string(row->kind->id)});
  std::ranges::move(manual::RemedyNames(), std::back_inserter(names));
  return names;
}

/// `code`: a code or a name; empty for the list of all.
options::ExitStatus Explain(const std::string& code) {
  if (code.empty()) {
    terminal::Print(terminal::Fitted(manual::ExplanationList(), terminal::TerminalWidth()));
    return options::ExitStatus::kGood;
  }
  const auto found = manual::FindExplanations(code);
  for (std::size_t i = 0; i < found.size(); ++i)
    terminal::Print((i > 0 ? "\n" : "") +
                    manual::ExplanationText(*found[i], RenderedWrong(*found[i])));
  if (!found.empty()) return options::ExitStatus::kGood;
  if (const std::string text = manual::RemedyText(code); !text.empty()) {
    terminal::Print(text);
    return options::ExitStatus::kGood;
  }
  const std::vector<std::string> names = CodesAndNames();
  throw options::CommandError(fmt::format(
      "there is no code '{}'; {}", code,
      options::Suggestion(code, {names.begin(), names.end()}, "`cdb explain` lists them")));
}

void DeclareExplain(options::Subcommand& command) {
  const auto code = std::make_shared<std::string>();
  command.Optional(
      "CODE", *code,
      "a code such as E0201, a name, a verdict, or noisy; without it, all codes are listed");
  command.Action([code] { return Explain(*code); });
}

}  // namespace

options::Command ExplainCommand() {
  return {
      .name = "explain",
      .help = "explain an error or a warning, by examples, or a verdict, with causes and remedies",
      .declare = DeclareExplain,
      .words = CodesAndNames};
}

}  // namespace cdb::cli
