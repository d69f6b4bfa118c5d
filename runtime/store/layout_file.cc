#include "runtime/store/layout_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <map>
#include <vector>

#include "runtime/store/hdf5/chunks.h"
#include "runtime/store/versions.h"

namespace cdb::store {
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

/// The attributes that a small file has, besides flags.
constexpr const char* kSmallAttributes[] = {"parameter", "units", "component_units"};

void SetSmall(hdf5::Dataset& dataset, const std::map<std::string, std::string>& attributes) {
  for (const char* name : kSmallAttributes)
    if (const auto found = attributes.find(name); found != attributes.end())
      dataset.SetText(name, found->second);
}

}  // namespace

hdf5::ExpectedMembers MembersOf(const Layout& layout, std::string_view group) {
  unsigned count = 0;
  std::size_t bytes = 0;
  const auto add = [&](const std::string& name) {
    if (name.substr(0, name.rfind('/') + 1) != group) return;
    ++count;
    bytes += name.size() - group.size();
  };
  for (const Dimension& dimension : layout.dimensions) add(dimension.name);
  for (const Array& array : layout.arrays) add(array.name);
  return {count, static_cast<unsigned>(bytes / std::max(count, 1u)) + 1};
}

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

void CreateSmallArrays(hdf5::File& file, const Layout& layout) {
  for (const Dimension& dimension : layout.dimensions)
    CreateGroups(file, dimension.name, [&](const std::string& group) {
      file.CreateGroup(group, MembersOf(layout, group + "/"));
    });
  for (const Dimension& dimension : layout.dimensions) {
    const bool is_long =
        dimension.numbers.size() * hdf5::ItemBytes(dimension.type) > hdf5::kMostInHeader;
    hdf5::Shape chunk;
    if (is_long) {
      chunk = {dimension.size};
      hdf5::SplitEvenly(chunk, 0, hdf5::ItemBytes(dimension.type));
    }
    hdf5::Dataset dataset = file.CreateDataset(
        {dimension.name, dimension.type, {dimension.size}, chunk, 0, /*is_small=*/true});
    if (!dimension.numbers.empty()) dataset.Write(dimension.numbers);
    SetSmall(dataset, dimension.attributes);
  }
  for (const Array& array : layout.arrays) {
    hdf5::Dataset dataset = file.CreateDataset(
        {array.name, array.type, array.shape, array.chunk, array.fill, /*is_small=*/true});
    SetSmall(dataset, array.attributes);
    SetFlags(dataset, array);
  }
}

void WriteHead(hdf5::File& file, const plan::Plan& plan, const PlanFacts& facts,
               std::string_view what) {
  file.SetText("Conventions", kConventions);
  file.SetText("title", plan.title.empty() ? plan.benchmark : plan.title);
  file.SetText("source", plan.source);
  file.SetText("comment", kComment);
  file.SetText("schema", kSchema);
  file.SetNumber("schema_version", Type::kInt32, kSchemaVersion);
  for (const auto& [name, text] : DatedHead(what)) file.SetText(name, text);
  file.SetText("plan_sha256", facts.sha256);
  file.SetText("benchmark", plan.benchmark);
  std::string axes;
  for (std::size_t i = 0; i < plan.axes.size(); ++i)
    axes.append(i == 0 ? "" : " ").append(plan.axes[i].name);
  file.SetText("axes", axes);
}

HeadTexts DatedHead(std::string_view what) {
  const std::string now = Now();
  return {{"history", fmt::format("{} cdb: {}", now, what)}, {"date_created", now}};
}

}  // namespace cdb::store
