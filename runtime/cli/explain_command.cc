// `cdb explain`: a kind of error or warning, with a wrong and a right example.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/render.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/subcommand.h"
#include "runtime/manual/explanation.h"
#include "runtime/report/console.h"
#include "runtime/report/wrap.h"

namespace cdb::cli {
namespace {

/// What `cdb check` says of the wrong example.
std::string RenderedWrong(const manual::Explanation& explanation) {
  const auto read = [&](const std::string& path, std::string& why) -> std::optional<std::string> {
    if (path == "wrong.cdb") return std::string(explanation.wrong);
    why = "No such file or directory";
    return std::nullopt;
  };
  return dsl::Render(CompileWith("wrong.cdb", read, std::nullopt).diagnostics,
                     RenderOptionsForTerminal());
}

/// `code`: a code or a name; empty for the list of all.
ExitStatus Explain(const std::string& code) {
  if (code.empty()) {
    report::Print(report::Fitted(manual::ExplanationList(), report::TerminalWidth()));
    return ExitStatus::kGood;
  }
  const auto found = manual::FindExplanations(code);
  for (std::size_t i = 0; i < found.size(); ++i)
    report::Print((i > 0 ? "\n" : "") +
                  manual::ExplanationText(*found[i], RenderedWrong(*found[i])));
  if (!found.empty()) return ExitStatus::kGood;
  std::vector<std::string_view> names;
  for (const manual::Explanation* row : manual::AllExplanations())
    names.insert(names.end(), {row->kind->code, row->kind->id});
  const std::string_view near = dsl::DidYouMean(code, names);
  throw CommandError(fmt::format("there is no code '{}'; {}", code,
                                 near.empty() ? std::string("`cdb explain` lists them")
                                              : fmt::format("did you mean '{}'?", near)));
}

}  // namespace

void AddExplainCommand(CLI::App& app, ExitStatus& status) {
  const auto code = std::make_shared<std::string>();
  Subcommand command(app, "explain", "an error or a warning, with a wrong and a right example");
  command.Optional("CODE", *code, "such as E0201, or its name; without it, all are listed");
  command.Action(status, [code] { return Explain(*code); });
}

}  // namespace cdb::cli
