#include "runtime/cli/help/topics.h"

#include <fmt/format.h>

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

#include "compiler/analysis/pruning.h"
#include "compiler/compile.h"
#include "compiler/lints/lints.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/schema.h"
#include "dsl/parser.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/manual/cluster.h"
#include "runtime/manual/detector.h"
#include "runtime/manual/document.h"
#include "runtime/manual/language.h"
#include "runtime/manual/limits.h"
#include "runtime/manual/statistics.h"
#include "runtime/manual/suite.h"
#include "runtime/manual/word.h"
#include "runtime/measure/series.h"
#include "runtime/measure/verdict.h"
#include "runtime/store/store.h"
#include "runtime/suite/standard.h"
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
    table.AddRow({parameter.FullName(), std::string(parameter.default_text),
                  std::string(parameter.unit), std::string(parameter.doc)});
  return table.Text();
}

std::string AllStatuses() {
  std::string text = "Values of status:";
  for (std::size_t i = 0; i < std::size(store::kStatusNames); ++i)
    text += fmt::format(" {} {}", i, store::kStatusNames[i]);
  return text + "\n\n";
}

std::string AllSeriesText() {
  terminal::Table table;
  table.KeepWhole();
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
  const auto rows = measure::Verdicts();
  for (auto row = rows.rbegin(); row != rows.rend(); ++row)
    table.AddRow({fmt::format("{}", static_cast<int>(row->verdict)), std::string(row->name),
                  std::string(row->doc)});
  return std::string(manual::kVerdictsReference) + table.Text();
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
  for (const suite::StandardScene& scene : suite::StandardScenes())
    table.AddRow({scene.Id(), std::string(scene.what), std::string(scene.error),
                  terminal::ShortNumber(scene.bound),
                  std::string(measure::VerdictName(scene.worst_verdict))});
  return fmt::format("{}Version {}\n\n{}", manual::kSuiteReference, suite::kSuiteVersion,
                     table.Text());
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
  if (folders.empty())
    return "scenarios: none lie beside this program; installing cdb brings them\n";
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

constexpr Topic kTopics[] = {
    {"language", "the language of .cdb files",
     [] { return std::string(manual::kLanguageReference); }},
    {"parameters", "every parameter with its default", AllParameters},
    {"omit", "the parts of the engine that a run omits",
     [] { return std::string(manual::kOmitReference) + AllComponents() + "\n"; }},
    {"lints", "warnings of scenes that Bullet cannot simulate well",
     [] { return std::string(manual::kLintsReference) + AllLints() + "\n"; }},
    {"accuracy", "errors, and the ground truth that runs are compared with",
     [] { return std::string(manual::kAccuracyReference) + AllErrors(); }},
    {"results", "the contents of a results file",
     [] { return std::string(manual::kResultsReference) + AllStatuses() + AllSeriesText(); }},
    {"statistics", "figures and intervals of cdb show and cdb compare",
     [] { return std::string(manual::kStatisticsReference); }},
    {"document", "the JSON of cdb show --json and of pages",
     [] { return std::string(manual::kDocumentReference); }},
    {"traces", "recorded boxes, and timing detectors on them",
     [] { return std::string(manual::kTracesReference); }},
    {"verdicts", "the verdicts on a run, and their criteria", AllVerdicts},
    {"noise", "disturbances by other programs, and repeating disturbed runs",
     [] { return std::string(manual::kNoiseReference); }},
    {"suite", "the standard suite: scenes, scores and comparable results", AllStandardScenes},
    {"limits", "limits of time and memory, and confinement",
     [] { return std::string(manual::kLimitsReference); }},
    {"cluster", "a sweep on many machines: Slurm, GNU parallel, ssh",
     [] { return std::string(manual::kClusterReference); }},
    {"objects", "the object types", manual::ObjectReference},
    {"detectors", "the detectors, and how they are timed", manual::DetectorReference},
    {"layouts", "the layouts, which place objects", manual::LayoutReference},
    {"schedules", "the schedules, which change a vector during a run", manual::ScheduleReference},
    {"scenarios", "the scenarios that come with cdb, for `cdb run` and `use`", Scenarios},
};

}  // namespace

std::span<const Topic> Topics() { return kTopics; }

}  // namespace cdb::help
