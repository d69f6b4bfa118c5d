#include "runtime/results/layout_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "runtime/results/versions.h"

namespace cdb::results {
namespace {

using hdf5::Type;

/// netCDF's mark for a dimension without a coordinate, from its file format specification.
constexpr std::string_view kNoCoordinate = "This is a netCDF dimension but not a netCDF variable.";

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
  for (const Dimension& dimension : layout.dimensions)
    CreateGroups(file, dimension.name, [&](const std::string& group) { file.CreateGroup(group); });
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
  file.AttachScales(attachments);
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
}

}  // namespace cdb::results
