// `cdb fmt`: scenario files in the standard layout.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "dsl/format.h"
#include "dsl/parser.h"
#include "dsl/render.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/subcommand.h"
#include "runtime/report/console.h"
#include "runtime/store/safe_file.h"

namespace cdb::cli {
namespace {

struct FormatArguments {
  std::vector<std::string> files;
  bool check = false;  ///< change nothing; exit status 1 where something would change
};

ExitStatus FormatFiles(const FormatArguments& arguments) {
  ExitStatus status = ExitStatus::kGood;
  for (const std::string& name : arguments.files) {
    const std::string file = FileOrStandardInput(name);
    const auto source = std::make_shared<const dsl::Source>(file, ReadText(file));
    dsl::Diagnostics diagnostics;
    dsl::Parse(source, diagnostics);
    if (diagnostics.has_errors()) {
      report::SayExact(dsl::Render(diagnostics, RenderOptionsForTerminal()));
      status = ExitStatus::kScenario;
      continue;
    }
    const std::string formatted = dsl::Format(*source);
    if (file == kStandardInput && !arguments.check) {
      report::PrintExact(formatted);
      continue;
    }
    if (formatted == source->text()) continue;
    if (arguments.check) {
      report::Say(fmt::format("{} is not laid out as `cdb fmt` does it\n", file));
      status = ExitStatus::kScenario;
    } else {
      store::WriteWhole(formatted, file);
    }
  }
  return status;
}

}  // namespace

void AddFormatCommand(CLI::App& app, ExitStatus& status) {
  const auto arguments = std::make_shared<FormatArguments>();
  Subcommand command(app, "fmt", "format scenario files");
  command.Required("FILE", arguments->files,
                   "scenario files; - reads standard input and writes standard output");
  command.Flag("--check", arguments->check, "change nothing; exit status 1 if it would");
  command.Action(status, [arguments] { return FormatFiles(*arguments); });
}

}  // namespace cdb::cli
