#include "runtime/store/layout_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

namespace cdb::store {
namespace {

using hdf5::Type;

/// netCDF's mark, by its file format specification, of a dimension without a coordinate.
constexpr std::string_view kNoCoordinate = "This is a netCDF dimension but not a netCDF variable.";

std::string Now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

}  // namespace

void CreateArrays(hdf5::File& file, const Layout& layout) {
  for (const Array& array : layout.arrays)
    for (std::size_t slash = array.name.find('/'); slash != std::string::npos;
         slash = array.name.find('/', slash + 1))
      if (const std::string group = array.name.substr(0, slash); !file.Has(group))
        file.CreateGroup(group);
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
    dataset.MakeScale(has_coordinate ? dimension.name
                                     : fmt::format("{}{:10}", kNoCoordinate, dimension.size));
    for (const auto& [name, text] : dimension.attributes) dataset.SetText(name.c_str(), text);
  }
  std::vector<hdf5::Group::Attachment> attachments;
  for (const Array& array : layout.arrays) {
    hdf5::Dataset dataset =
        file.CreateDataset({array.name, array.type, array.shape, array.chunk, array.fill});
    if (array.has_fill_value) dataset.SetNumbers("_FillValue", array.type, {{array.fill}});
    for (const auto& [name, text] : array.attributes) dataset.SetText(name.c_str(), text);
    if (!array.flags.empty()) {
      const auto count = static_cast<std::uint64_t>(std::ranges::count(array.flags, ' ')) + 1;
      dataset.SetNumbers("flag_values", array.type, Indices(count));
      dataset.SetText("flag_meanings", array.flags);
    }
    attachments.push_back({array.name, array.dimensions});
  }
  file.AttachScales(attachments);
}

void WriteHead(hdf5::File& file, const plan::Plan& plan, const PlanFacts& facts,
               const Layout& layout, std::string_view what) {
  const std::string now = Now();
  file.SetText("title", plan.title.empty() ? plan.benchmark : plan.title);
  file.SetText("source", plan.source);
  file.SetText("schema", kSchema);
  file.SetNumber("schema_version", Type::kInt32, kSchemaVersion);
  file.SetText("history", fmt::format("{} cdb: {}", now, what));
  file.SetText("date_created", now);
  file.SetText("plan_sha256", facts.sha256);
  file.SetText("benchmark", plan.benchmark);
  std::string axes;
  for (std::size_t i = 0; i < plan.axes.size(); ++i)
    axes.append(i == 0 ? "" : " ").append(layout.dimensions[i].name);
  file.SetText("axes", axes);
}

void CheckHead(const hdf5::File& file, const std::string& name) {
  if (file.Text("schema") != kSchema)
    throw StoreError(
        fmt::format("{}: is HDF5, but not a result of cdb; it was left as it is: "
                    "choose another file",
                    name));
  const double version = file.Number("schema_version");
  if (version != kSchemaVersion)
    throw StoreError(
        fmt::format("{}: is a result of schema version {}, and this cdb reads version "
                    "{}; it was left as it is: use the cdb that wrote it",
                    name, version, kSchemaVersion));
}

}  // namespace cdb::store
