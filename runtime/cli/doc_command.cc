#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/checks/lints.h"
#include "compiler/plan/pruning.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "dsl/diagnostics.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/measure/series.h"
#include "runtime/measure/verdict.h"
#include "runtime/report/console.h"
#include "runtime/report/detector_reference.h"
#include "runtime/report/language_reference.h"
#include "runtime/report/table.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;
using schema::Parameter;

using schema::ParametrisedWord;

/// `stack(height: all, gap: fit, spacing: fit)`, `at(x, y, z)`.
std::string Signature(const ParametrisedWord& info) {
  std::string text;
  for (const Parameter& argument : info.arguments) {
    if (!text.empty()) text += ", ";
    text += argument.name;
    if (!argument.default_text.empty()) text += fmt::format(": {}", argument.default_text);
  }
  return fmt::format("{}({})", info.name, text);
}

/// A table of every argument.
std::string Arguments(const std::vector<const ParametrisedWord*>& calls) {
  report::Table table;
  for (const char* head : {"argument", "of", "takes", "unit", ""}) table.AddColumn(head, false);
  for (const ParametrisedWord* info : calls)
    for (const Parameter& argument : info->arguments)
      table.AddRow({std::string(argument.name), std::string(info->name), argument.Takes(),
                    std::string(argument.unit), std::string(argument.doc)});
  return table.Text();
}

std::vector<const ParametrisedWord*> CallsOf(const Parameter& parameter) {
  std::vector<const ParametrisedWord*> calls;
  for (const std::string_view name : parameter.AllCalls())
    calls.push_back(schema::FindParametrisedWord(name));
  return calls;
}

/// Words that stand alone and words with arguments, then the arguments.
template <typename Rows>
std::string Words(const char* title, const Rows& rows,
                  const std::vector<const ParametrisedWord*>& calls) {
  report::Table table;
  table.AddColumn(title, false);
  table.AddColumn("", false);
  for (const auto& row : rows) table.AddRow({std::string(row.name), std::string(row.doc)});
  for (const ParametrisedWord* info : calls)
    table.AddRow({Signature(*info), std::string(info->doc)});
  return table.Text() + "\n" + Arguments(calls);
}

std::string Words(const char* title, const std::vector<const ParametrisedWord*>& calls) {
  return Words(title, std::span<const schema::LayoutInfo>(), calls);
}

std::string OneParameter(const Parameter& parameter) {
  std::string text = fmt::format("{}\n  {}\n", parameter.FullName(), parameter.doc);
  text += fmt::format("  takes    {}\n", parameter.Takes());
  text += fmt::format("  default  {}\n", parameter.default_text);
  if (!parameter.unit.empty()) text += fmt::format("  unit     {}\n", parameter.unit);
  const auto calls = CallsOf(parameter);
  return calls.empty() ? text : text + "\n" + Words("with arguments", calls);
}

std::string AllParameters() {
  report::Table table;
  table.AddColumn("parameter", false);
  table.AddColumn("default", false);
  table.AddColumn("unit", false);
  table.AddColumn("", false);
  for (const Parameter& parameter : schema::Schema())
    table.AddRow({parameter.FullName(), std::string(parameter.default_text),
                  std::string(parameter.unit), std::string(parameter.doc)});
  return table.Text();
}

std::string AllSeriesText() {
  report::Table table;
  table.AddColumn("dataset", false);
  table.AddColumn("recorded by", false);
  table.AddColumn("unit", false);
  table.AddColumn("", false);
  for (const measure::Series& series : measure::AllSeries())
    table.AddRow({std::string(series.name), std::string(series.records), std::string(series.unit),
                  std::string(series.doc)});
  return table.Text();
}

std::string AllComponents() {
  report::Table table;
  table.AddColumn("component", false);
  table.AddColumn("what it is", false);
  table.AddColumn("without it", false);
  for (const schema::ComponentInfo& info : schema::Components())
    table.AddRow({std::string(info.name), std::string(info.doc),
                  info.IsVisible() ? std::string(info.changes) : "only time changes"});
  return table.Text();
}

std::string AllVerdicts() {
  report::Table table;
  table.AddColumn("", true);
  table.AddColumn("verdict", false);
  table.AddColumn("when", false);
  const auto rows = measure::Verdicts();
  for (auto row = rows.rbegin(); row != rows.rend(); ++row)
    table.AddRow({fmt::format("{}", static_cast<int>(row->verdict)), std::string(row->name),
                  std::string(row->doc)});
  return std::string(report::kVerdictsReference) + table.Text();
}

std::string AllLints() {
  report::Table table;
  for (const char* head : {"lint", "number", "limit", "beyond it"}) table.AddColumn(head, false);
  for (const checks::LintInfo& info : checks::Lints())
    table.AddRow({std::string(info.kind.id), std::string(info.number), std::string(info.threshold),
                  fmt::format(fmt::runtime(info.foretells), "will")});
  return table.Text();
}

std::string AllErrors() {
  report::Table table;
  for (const char* head : {"error", "metrics", "unit", "held against", "up to", ""})
    table.AddColumn(head, false);
  for (const schema::ErrorInfo& error : schema::Errors())
    table.AddRow({std::string(error.name), std::string(error.metric), std::string(error.unit),
                  error.needs_truth ? "truth" : "nothing", error.to_horizon ? "horizon" : "end",
                  std::string(error.doc)});
  report::Table forms;
  forms.AddColumn("closed form", false);
  forms.AddColumn("", false);
  for (const schema::ClosedFormInfo& form : schema::ClosedForms())
    forms.AddRow({std::string(form.name), std::string(form.doc)});
  return table.Text() + "\n" + forms.Text();
}

template <typename Rows, typename Doc>
std::string Names(const char* title, const Rows& rows, Doc doc) {
  report::Table table;
  table.AddColumn(title, false);
  table.AddColumn("", false);
  for (const auto& row : rows) table.AddRow({std::string(row.name), doc(row)});
  return table.Text();
}

std::string Objects() {
  return Words("objects", schema::ObjectTypes(), CallsOf(*schema::GroupParameter("type")));
}

std::string Layouts() {
  return Words("layouts", schema::Layouts(), CallsOf(*schema::GroupParameter("location")));
}

std::string Schedules() {
  return Words("schedules", CallsOf(*schema::WorldParameter("acceleration")));
}

/// The scenarios of the library, a table for each folder, with their first comment line.
std::string Scenarios() {
  const fs::path library = ScenarioLibrary();
  std::map<std::string, std::vector<fs::path>> folders;
  std::error_code error;
  if (!library.empty())
    for (const auto& entry : fs::recursive_directory_iterator(library, error))
      if (entry.path().extension() == ".cdb")
        folders[fs::relative(entry.path().parent_path(), library, error)].push_back(entry.path());
  if (folders.empty())
    return "scenarios: none lie beside this program; installing cdb brings them\n";
  std::string text;
  for (auto& [folder, files] : folders) {
    report::Table table;
    table.AddColumn("scenarios: " + folder, false);
    table.AddColumn("", false);
    std::ranges::sort(files);
    for (const fs::path& file : files) {
      std::string line;
      std::ifstream in(file);
      std::getline(in, line);
      line.erase(0, std::min(line.find_first_not_of("# "), line.size()));
      table.AddRow({(fs::path(folder) / file.stem()).string(), line});
    }
    text += (text.empty() ? "" : "\n") + table.Text();
  }
  return text;
}

struct Topic {
  std::string_view name, doc;
  std::string (*text)();
};

constexpr Topic kTopics[] = {
    {"language", "how a .cdb file is written",
     [] { return std::string(report::kLanguageReference); }},
    {"parameters", "every parameter with its default", AllParameters},
    {"omit", "what a run leaves out, and when",
     [] { return std::string(report::kOmitReference) + AllComponents() + "\n"; }},
    {"lints", "numbers that Bullet cannot follow, before anything runs",
     [] { return std::string(report::kLintsReference) + AllLints() + "\n"; }},
    {"accuracy", "errors beside timings, and what they are held against",
     [] { return std::string(report::kAccuracyReference) + AllErrors(); }},
    {"results", "what a results file holds",
     [] { return std::string(report::kResultsReference) + AllSeriesText(); }},
    {"traces", "recorded boxes, and detectors that are run on them",
     [] { return std::string(report::kTracesReference); }},
    {"verdicts", "how a run can end, and by which measure", AllVerdicts},
    {"objects", "what can be placed", Objects},
    {"detectors", "what can be timed, and how", report::DetectorReference},
    {"layouts", "how objects can be placed", Layouts},
    {"schedules", "how a vector changes while a run goes on", Schedules},
    {"scenarios", "what comes with cdb, for `cdb run` and for `use`", Scenarios},
};

}  // namespace

int DocCommand(const std::string& name) {
  if (name.empty()) {
    report::Print(
        Names("cdb doc", kTopics, [](const Topic& topic) { return std::string(topic.doc); }));
    report::Print(
        "  or the name of a parameter, a block or a word: cdb doc size, cdb doc links, cdb doc "
        "ring\n");
    return kExitGood;
  }
  bool found = false;
  for (const Topic& topic : kTopics) {
    if (topic.name != name) continue;
    report::Print(topic.text());
    found = true;
  }
  std::vector<std::string> names;
  for (const Parameter& parameter : schema::Schema()) {
    names.push_back(parameter.FullName());
    names.emplace_back(parameter.name);
    const std::string last(parameter.name.substr(parameter.name.find('.') + 1));
    if (name != parameter.FullName() && name != parameter.name && name != last &&
        !parameter.name.starts_with(name + "."))
      continue;
    report::Print(OneParameter(parameter));
    found = true;
  }
  for (const ParametrisedWord& info : schema::ParametrisedWords()) {
    names.emplace_back(info.name);
    if (name != info.name) continue;
    report::Print(Words("word", {&info}));
    found = true;
  }
  if (found) return kExitGood;
  for (const Topic& topic : kTopics) names.emplace_back(topic.name);
  const std::string_view near = dsl::DidYouMean(name, {names.begin(), names.end()});
  throw CommandError(fmt::format("there is nothing about '{}'; {}", name,
                                 near.empty() ? std::string("`cdb doc` lists what there is")
                                              : fmt::format("did you mean '{}'?", near)));
}

int ListCommand(const std::string& what) {
  bool found = false;
  for (const std::string_view name :
       {"objects", "detectors", "layouts", "schedules", "scenarios"}) {
    if (!what.empty() && what != name) continue;
    for (const Topic& topic : kTopics)
      if (topic.name == name)
        report::Print((found ? "\n" : "") +
                      (name == "detectors" ? report::DetectorTables() : topic.text()));
    found = true;
  }
  if (found) return kExitGood;
  throw CommandError(fmt::format(
      "there is no list of '{}'; there are objects, detectors, layouts, schedules, scenarios",
      what));
}

}  // namespace cdb::cli
