// Creates the arrays of a layout in a file, and writes what is known before its runs.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <limits>
#include <string>
#include <vector>

#include "runtime/results/hdf5/file.h"
#include "runtime/results/layout.h"
#include "runtime/results/versions.h"

namespace cdb::results {
namespace {

using hdf5::Type;

constexpr std::string_view kComment =
    "Durations are whole nanoseconds as float64, which holds them exactly up to 104 days, has a "
    "value for none, and is a number in every language. Counts are int32. The fill value (NaN, or "
    "-1 for counts) marks cycles that did not run and runs that do not exist. Coordinates of text "
    "are labels, and axes are in the order of the scenario, so that neither need be monotonic.";

std::string Now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

/// Calls `create` for the missing groups on the path to `path`.
void CreateGroups(hdf5::File& file, const std::string& path, const auto& create) {
  for (std::size_t slash = path.find('/'); slash != std::string::npos;
       slash = path.find('/', slash + 1))
    if (const std::string group = path.substr(0, slash); !file.Has(group)) create(group);
}

void SetFlags(hdf5::Dataset& dataset, const Array& array) {
  if (array.flags.empty()) return;
  const auto count = static_cast<std::uint64_t>(std::ranges::count(array.flags, ' ')) + 1;
  dataset.SetNumbers("flag_values", array.type, Indices(count));
  dataset.SetText("flag_meanings", array.flags);
}

}  // namespace

void CreateArrays(hdf5::File& file, const Layout& layout) {
  const auto create = [&](const std::string& group) { file.CreateGroup(group); };
  for (const Dimension& dimension : layout.dimensions) CreateGroups(file, dimension.name, create);
  for (const Array& array : layout.arrays) CreateGroups(file, array.name, create);
  for (const Dimension& dimension : layout.dimensions) {
    hdf5::Dataset dataset =
        file.CreateDataset({dimension.name, dimension.type, {dimension.size}, {}, 0});
    const bool is_text = dimension.type == Type::kText;
    if (is_text) {
      dataset.WriteText(dimension.texts);
    } else if (!dimension.numbers.empty()) {
      dataset.Write(dimension.numbers);
    }
    const bool has_coordinate = is_text || !dimension.numbers.empty();
    dataset.MakeScale(has_coordinate ? dimension.name.substr(dimension.name.rfind('/') + 1)
                                     : fmt::format("{}{:10}", kNoCoordinate, dimension.size));
    for (const auto& [name, text] : dimension.attributes) dataset.SetText(name.c_str(), text);
  }
  std::vector<hdf5::Group::Attachment> attachments;
  for (const Array& array : layout.arrays) {
    hdf5::Dataset dataset =
        file.CreateDataset({array.name, array.type, array.shape, array.chunk, array.fill});
    if (array.has_fill_value) dataset.SetNumbers("_FillValue", array.type, {{array.fill}});
    for (const auto& [name, text] : array.attributes) dataset.SetText(name.c_str(), text);
    SetFlags(dataset, array);
    attachments.push_back({array.name, array.dimensions});
  }
  for (const Column& column : layout.columns) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    hdf5::Dataset dataset =
        file.CreateDataset({column.name, Type::kFloat64, {column.values.size()}, {}, kNone});
    dataset.Write(column.values);
    dataset.SetNumbers("_FillValue", Type::kFloat64, {{kNone}});
    for (const auto& [name, text] : column.attributes) dataset.SetText(name.c_str(), text);
    dataset.SetNumber(kFirstAttribute, Type::kFloat64, column.first);
    dataset.SetNumber(kLastAttribute, Type::kFloat64, column.last);
    attachments.push_back({column.name, {column.dimension}});
  }
  file.AttachScales(attachments);
}

void WriteRequirements(hdf5::File& file, const std::vector<plan::Requirement>& requirements,
                       const StoredAnswers* answers) {
  if (requirements.empty()) return;
  std::vector<std::string> figures, comparisons;
  std::vector<double> limits;
  for (const plan::Requirement& requirement : requirements) {
    figures.push_back(requirement.figure.Text());
    comparisons.emplace_back(plan::ComparisonText(requirement.comparison));
    limits.push_back(requirement.limit);
  }
  const auto open = [&](const char* name) { return file.OpenDataset(kRequirementsGroup + name); };
  open("figure").WriteText(figures);
  open("comparison").WriteText(comparisons);
  open("limit").Write(limits);
  if (answers == nullptr) return;
  open("answer").Write(answers->answer);
  open("value").Write(answers->value);
  open("low").Write(answers->low);
  open("high").Write(answers->high);
}

void WriteBoundaries(hdf5::File& file, const plan::Plan& plan, const StoredAnswers* answers) {
  if (!plan.SearchAxis() || answers == nullptr) return;
  const auto write = [&](const char* name, const std::vector<double>& values) {
    file.OpenDataset(kBoundaryGroup + name).Write(values);
  };
  const StoredAnswers::Boundaries& boundaries = answers->boundaries;
  write("outcome", boundaries.outcome);
  write("value", boundaries.value);
  write("low", boundaries.low);
  write("high", boundaries.high);
  write("changes", boundaries.changes);
  write("probes", boundaries.probes);
}

void WriteRaces(hdf5::File& file, const plan::Plan& plan, const StoredAnswers* answers) {
  if (plan.RaceAxes().empty() || answers == nullptr) return;
  const auto write = [&](const char* name, const std::vector<double>& values) {
    file.OpenDataset(kRaceGroup + name).Write(values);
  };
  const StoredAnswers::Races& races = answers->races;
  write("outcome", races.outcome);
  write("repeats", races.repeats);
  write("against", races.against);
  write("ratio", races.ratio);
  write("low", races.low);
  write("high", races.high);
}

void WriteHead(hdf5::File& file, const plan::Plan& plan, const PlanFacts& facts,
               std::string_view what) {
  file.SetText("Conventions", kConventions);
  file.SetText("title", plan.title.empty() ? plan.benchmark : plan.title);
  file.SetText("source", plan.source);
  file.SetText("comment", kComment);
  file.SetText("schema", kSchema);
  file.SetNumber("schema_version", Type::kInt32, kSchemaVersion);
  const std::string now = Now();
  file.SetText("history", fmt::format("{} cdb: {}", now, what));
  file.SetText("date_created", now);
  file.SetText("plan_sha256", facts.sha256);
  file.SetText("benchmark", plan.benchmark);
  std::string axes;
  for (std::size_t i = 0; i < plan.axes.size(); ++i)
    axes.append(i == 0 ? "" : " ").append(plan.axes[i].name);
  file.SetText("axes", axes);
  if (plan.budget_s) file.SetNumber("budget", Type::kFloat64, *plan.budget_s);
  if (plan.frame_s) file.SetNumber("frame", Type::kFloat64, *plan.frame_s);
}

}  // namespace cdb::results
