#include "runtime/cli/help/topics.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "compiler/analysis/coverage.h"
#include "compiler/analysis/pruning.h"
#include "compiler/compile.h"
#include "compiler/lints/lints.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/schema.h"
#include "dsl/parser.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/figures/suite.h"
#include "runtime/manual/detector.h"
#include "runtime/manual/lookup.h"
#include "runtime/manual/markdown.h"
#include "runtime/manual/page.h"
#include "runtime/protocol/series.h"
#include "runtime/protocol/verdict.h"
#include "runtime/results/store.h"
#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::help {
namespace {

namespace fs = std::filesystem;
using schema::Parameter;

std::string AllParameters() {
  terminal::Table table;
  table.KeepWhole();
  table.AddColumn("parameter", false);
  table.AddColumn("default", false);
  table.AddColumn("unit", false);
  table.AddColumn("", false);
  for (const Parameter& parameter : schema::Schema())
    table.AddRow({parameter.FullName(), std::string(parameter.DefaultText()), parameter.UnitText(),
                  std::string(parameter.doc)});
  return table.Text();
}

std::string StatusesAndSeries() {
  std::string statuses = "Values of status:";
  for (std::size_t i = 0; i < std::size(results::kStatusNames); ++i)
    statuses += fmt::format(" {} {}", i, results::kStatusNames[i]);
  terminal::Table table;
  table.KeepWhole();
  table.AddColumn("dataset", false);
  table.AddColumn("recorded by", false);
  table.AddColumn("unit", false);
  table.AddColumn("", false);
  for (const protocol::Series& series : protocol::AllSeries())
    table.AddRow({std::string(series.name), std::string(series.records), std::string(series.unit),
                  std::string(series.doc)});
  return statuses + "\n\n" + table.Text();
}

std::string AllComponents() {
  terminal::Table table;
  table.KeepWhole();
  table.AddColumn("component", false);
  table.AddColumn("what is omitted", false);
  table.AddColumn("without it", false);
  for (const schema::ComponentInfo& info : schema::Components())
    table.AddRow({std::string(info.name), std::string(info.doc),
                  info.IsVisible() ? std::string(info.changes) : "only time changes"});
  return table.Text();
}

std::string AllVerdicts() {
  terminal::Table table;
  table.KeepWhole();
  table.AddColumn("", true);
  table.AddColumn("verdict", false);
  table.AddColumn("when", false);
  const auto rows = protocol::Verdicts();
  for (auto row = rows.rbegin(); row != rows.rend(); ++row)
    table.AddRow({fmt::format("{}", static_cast<int>(row->verdict)), std::string(row->name),
                  std::string(row->doc)});
  return table.Text();
}

std::string AllQuestions() {
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"question", "checked"}) table.AddColumn(head, false);
  for (const analysis::QuestionInfo& info : analysis::Questions())
    table.AddRow({std::string(info.name), std::string(info.doc)});
  return table.Text();
}

std::string AllLints() {
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"lint", "number", "limit", "beyond it"}) table.AddColumn(head, false);
  for (const lints::LintInfo& info : lints::Lints())
    table.AddRow({std::string(info.kind.id), std::string(info.number), std::string(info.threshold),
                  fmt::format(fmt::runtime(info.predicts), "will")});
  return table.Text();
}

std::string AllErrors() {
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"error", "metrics", "unit", "compared with", "up to", ""})
    table.AddColumn(head, false);
  for (const schema::ErrorInfo& error : schema::Errors())
    table.AddRow({std::string(error.name), std::string(error.metric), std::string(error.unit),
                  error.needs_truth ? "truth" : "nothing", error.to_horizon ? "horizon" : "end",
                  std::string(error.doc)});
  terminal::Table forms;
  forms.KeepWhole();
  forms.AddColumn("closed form", false);
  forms.AddColumn("", false);
  for (const schema::ClosedFormInfo& form : schema::ClosedForms())
    forms.AddRow({std::string(form.name), std::string(form.doc)});
  return table.Text() + "\n" + forms.Text();
}

std::string AllStandardScenes() {
  terminal::Table table;
  table.KeepWhole();
  for (const char* head : {"scene", "", "error", "bound", "worst verdict"})
    table.AddColumn(head, false);
  for (const figures::StandardScene& scene : figures::StandardScenes())
    table.AddRow({scene.Id(), std::string(scene.what), std::string(scene.error),
                  terminal::ShortNumber(scene.bound),
                  std::string(protocol::VerdictName(scene.worst_verdict))});
  return fmt::format("Version {}\n\n{}", figures::kSuiteVersion, table.Text());
}

/// `benchmarks: a, b`, in the order of the file.
std::string BenchmarksIn(const fs::path& file) {
  std::string why, names;
  auto text = compiler::ReadFromDisk(file.string(), why);
  if (!text) return "  " + why;
  dsl::Diagnostics diagnostics;
  const dsl::File tree = dsl::Parse(
      std::make_shared<const text::Source>(file.string(), std::move(*text)), diagnostics);
  int count = 0;
  for (const auto& item : tree.items)
    if (const auto* benchmark = std::get_if<dsl::Benchmark>(&item))
      names += (count++ == 0 ? "" : ", ") + benchmark->name.text;
  return fmt::format("  {}: {}", count == 1 ? "benchmark" : "benchmarks", names);
}

/// The scenarios of the library as one table for each folder, with the first comment line of each
/// scenario and its benchmarks.
std::string Scenarios() {
  const fs::path library = options::ScenarioLibrary();
  std::map<std::string, std::vector<fs::path>> folders;
  std::error_code error;
  if (!library.empty())
    for (const auto& entry : fs::recursive_directory_iterator(library, error))
      if (entry.path().extension() == ".cdb")
        folders[fs::relative(entry.path().parent_path(), library, error)].push_back(entry.path());
  if (folders.empty()) return "scenarios: none are installed beside this program; install cdb\n";
  std::string text;
  for (auto& [folder, files] : folders) {
    terminal::Table table;
    table.KeepWhole();
    table.AddColumn("scenarios: " + folder, false);
    table.AddColumn("", false);
    std::ranges::sort(files);
    for (const fs::path& file : files) {
      std::string line;
      std::ifstream in(file);
      std::getline(in, line);
      line.erase(0, std::min(line.find_first_not_of("# "), line.size()));
      table.AddRow({(fs::path(folder) / file.stem()).string(), line});
      table.AddRow({"", BenchmarksIn(file)});
    }
    text += (text.empty() ? "" : "\n") + table.Text();
  }
  return text;
}

struct Part {
  std::string_view name;
  std::string (*text)();
};

constexpr Part kParts[] = {
    {"components", AllComponents},
    {"detectors", manual::DetectorTables},
    {"errors", AllErrors},
    {"families", manual::FamilyTable},
    {"layouts", manual::LayoutReference},
    {"lints", AllLints},
    {"objects", manual::ObjectReference},
    {"parameters", AllParameters},
    {"questions", AllQuestions},
    {"scenarios", Scenarios},
    {"scenes", AllStandardScenes},
    {"schedules", manual::ScheduleReference},
    {"series", StatusesAndSeries},
    {"verdicts", AllVerdicts},
};

}  // namespace

std::string GeneratedPart(std::string_view name) {
  for (const Part& part : kParts)
    if (part.name == name) return terminal::Fitted(part.text(), terminal::TerminalWidth());
  return {};
}

std::string TopicText(std::string_view name) {
  return manual::PageText(manual::PageNamed(name), terminal::TextWidth(), GeneratedPart);
}

std::vector<std::string_view> TopicNames() {
  std::vector<std::string_view> names;
  for (const manual::Page& page : manual::Pages())
    if (page.name != kListOfTopics) names.push_back(page.name);
  return names;
}

std::string CommandInfo::Synopsis() const {
  std::string text = "cdb " + name;
  for (const ArgumentInfo& argument : arguments) {
    const std::string shown = argument.name + (argument.is_repeated ? "..." : "");
    text += argument.is_required ? " " + shown : " [" + shown + "]";
  }
  return text;
}

std::vector<CommandInfo> CommandsOf(const CLI::App& app, std::span<const options::Command> rows) {
  std::vector<CommandInfo> commands;
  for (const CLI::App* command : app.get_subcommands({})) {
    CommandInfo info{command->get_name(), command->get_description(), {}, {}, {}};
    const auto row = std::ranges::find(rows, info.name, &options::Command::name);
    if (row->words != nullptr) info.words = row->words();
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_positional()) {
        info.arguments.push_back({option->get_name(true, false), option->get_description(),
                                  option->get_required(), option->get_expected_max() > 1});
        continue;
      }
      OptionInfo one{{}, option->get_description(), option->get_items_expected_max() > 0};
      for (const std::string& name : option->get_snames()) one.names.push_back("-" + name);
      for (const std::string& name : option->get_lnames()) one.names.push_back("--" + name);
      info.options.push_back(std::move(one));
    }
    commands.push_back(std::move(info));
  }
  return commands;
}

}  // namespace cdb::help
