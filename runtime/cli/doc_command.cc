// `cdb doc`: the reference of the language and of the results.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/compile.h"
#include "dsl/diagnostics.h"
#include "runtime/cli/command_line.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/subcommand.h"
#include "runtime/cli/topics.h"
#include "runtime/manual/lookup.h"
#include "runtime/report/console.h"
#include "runtime/report/table.h"
#include "runtime/report/wrap.h"

namespace cdb::cli {
namespace {

void PrintTopics() {
  report::Table table;
  table.KeepWhole();
  table.AddColumn("cdb doc", false);
  table.AddColumn("", false);
  for (const Topic& topic : Topics())
    table.AddRow({std::string(topic.name), std::string(topic.doc)});
  const std::string others =
      "  or the name of a parameter, a block, a word or a scenario: cdb doc size, cdb doc sweep, "
      "cdb "
      "doc paper/experiment2\n";
  report::Print(report::Fitted(table.Text() + others, report::TerminalWidth()));
}

/// Everything called `name`: a topic, and what the manual has of words and parameters. Empty for
/// nothing.
std::string ReferenceOf(const std::string& name) {
  std::string text;
  for (const Topic& topic : Topics())
    if (name == topic.name) text += topic.text();
  const std::string about = manual::TextAbout(name);
  return text + (text.empty() || about.empty() ? "" : "\n") + about;
}

/// The text of a scenario that comes with cdb; empty if there is none of that name.
std::string ScenarioText(const std::string& name) {
  const std::filesystem::path library = ScenarioLibrary();
  if (library.empty() || name.find("..") != name.npos) return {};
  std::string why;
  for (const char* extension : {"", ".cdb"})
    if (const auto text = compiler::ReadFromDisk((library / (name + extension)).string(), why))
      return *text;
  return {};
}

/// `name`: a topic, a parameter, a word, a scenario or a command; empty for the list of topics.
ExitStatus Doc(const std::string& name, const CLI::App& app) {
  if (name.empty()) {
    PrintTopics();
    return ExitStatus::kGood;
  }
  if (const std::string text = ReferenceOf(name); !text.empty()) {
    report::Print(report::Fitted(text, report::TerminalWidth()));
    return ExitStatus::kGood;
  }
  if (const std::string text = ScenarioText(name); !text.empty()) {
    report::PrintExact(text);
    return ExitStatus::kGood;
  }
  for (const CLI::App* command :
       app.get_subcommands([&](const CLI::App* one) { return one->get_name() == name; })) {
    report::Print(command->help());
    return ExitStatus::kGood;
  }
  const std::vector<std::string> names = WordsFor("doc");
  const std::string_view near = dsl::DidYouMean(name, {names.begin(), names.end()});
  throw CommandError(fmt::format("there is nothing about '{}'; {}", name,
                                 near.empty() ? std::string("`cdb doc` lists what there is")
                                              : fmt::format("did you mean '{}'?", near)));
}

}  // namespace

void AddDocCommand(CLI::App& app, ExitStatus& status) {
  const auto name = std::make_shared<std::string>();
  Subcommand command(app, "doc", "the reference: language, parameters, results");
  command.Optional("NAME", *name,
                   "a topic, a parameter, a word, a command, or a scenario that comes with cdb");
  command.Action(status, [name, &app] { return Doc(*name, app); });
}

}  // namespace cdb::cli
