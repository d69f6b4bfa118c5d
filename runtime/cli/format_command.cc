// `cdb fmt`: formats scenario files in the standard layout.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/format.h"
#include "dsl/parser.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

struct FormatArguments {
  std::vector<std::string> files;
  bool check = false;  ///< change nothing; exit status 1 if a file would change
};

options::ExitStatus FormatFiles(const FormatArguments& arguments) {
  options::ExitStatus status = options::ExitStatus::kGood;
  for (const std::string& name : arguments.files) {
    const std::string file = options::FileOrStandardInput(name);
    const auto source = std::make_shared<const text::Source>(file, options::ReadText(file));
    dsl::Diagnostics diagnostics;
    dsl::Parse(source, diagnostics);
    if (diagnostics.has_errors()) {
      terminal::SayExact(dsl::Render(diagnostics, options::RenderOptionsForTerminal()));
      status = options::ExitStatus::kScenarioError;
      continue;
    }
    const std::string formatted = dsl::Format(*source);
    if (file == options::kStandardInput && !arguments.check) {
      terminal::PrintExact(formatted);
      continue;
    }
    if (formatted == source->text()) continue;
    if (arguments.check) {
      terminal::Say(fmt::format("{} is not formatted; `cdb fmt` formats it\n", file));
      status = options::ExitStatus::kScenarioError;
    } else {
      files::WriteWhole(formatted, file);
    }
  }
  return status;
}

void DeclareFormat(options::Subcommand& command) {
  const auto arguments = std::make_shared<FormatArguments>();
  command.Required("FILE", arguments->files,
                   "scenario files; - reads standard input and writes standard output");
  command.Flag("--check", arguments->check,
               "change nothing; exit status 1 if a file is not formatted");
  command.Action([arguments] { return FormatFiles(*arguments); });
}

}  // namespace

options::Command FormatCommand() {
  return {.name = "fmt", .help = "format scenario files", .declare = DeclareFormat};
}

}  // namespace cdb::cli
