#include "runtime/results/store.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "compiler/schema/schema.h"
#include "runtime/results/hdf5/file.h"

namespace cdb::results {
namespace {

using hdf5::Type;

/// Separators of `labels`, in order of preference.
constexpr std::string_view kSeparators = " ;|\t\n";

/// The parameter's description in the schema, or the axis' own name for a `let` or `cases`.
std::string LongName(const plan::Axis& axis) {
  const std::string_view name = axis.parameter;
  const schema::Parameter* row = schema::FindParameter(name, false);
  if (row == nullptr) row = schema::FindParameter(name.substr(name.find('.') + 1), true);
  return std::string(row != nullptr ? row->doc : axis.name);
}

}  // namespace

std::vector<double> Indices(std::uint64_t n) {
  std::vector<double> indices(n);
  for (std::size_t i = 0; i < n; ++i) indices[i] = static_cast<double>(i);
  return indices;
}

Dimension Counted(std::string name, std::uint64_t size, std::string doc) {
  return {std::move(name),
          size,
          Type::kInt32,
          Indices(size),
          {},
          {{"units", kNoUnit}, {"long_name", std::move(doc)}},
          {}};
}

Dimension Labelled(std::string name, std::vector<std::string> texts, std::string doc) {
  Dimension dimension{std::move(name), texts.size(), Type::kText, {}, {}, {}, {}};
  for (const char separator : kSeparators) {
    const bool is_free = std::ranges::all_of(texts, [&](const std::string& text) {
      return !text.empty() && text.find(separator) == std::string::npos;
    });
    if (!is_free) continue;
    std::string labels = fmt::format("{}", fmt::join(texts, std::string(1, separator)));
    if (labels.size() > 32000)
      break;  // an attribute has a limited size; the dataset has all
              // labels
    dimension.attributes = {{"labels", std::move(labels)},
                            {"labels_separator", std::string(1, separator)}};
    break;
  }
  if (!doc.empty()) dimension.attributes.emplace("long_name", std::move(doc));
  dimension.texts = std::move(texts);
  return dimension;
}

Dimension AxisDimension(const plan::Axis& axis, bool is_integer) {
  Dimension dimension;
  if (axis.IsText()) {
    std::vector<std::string> texts;
    for (const auto& value : axis.values) texts.push_back(std::get<std::string>(value));
    dimension = Labelled(axis.name, std::move(texts), "");
  } else {
    dimension.name = axis.name;
    dimension.size = axis.values.size();
    dimension.type = is_integer ? Type::kInt32 : Type::kFloat64;
    for (const auto& value : axis.values) dimension.numbers.push_back(std::get<double>(value));
  }
  dimension.attributes.emplace("parameter", axis.parameter);
  dimension.attributes.emplace("units", axis.unit.empty() && !axis.IsText() ? kNoUnit : axis.unit);
  dimension.attributes.emplace("long_name", LongName(axis));
  return dimension;
}

namespace {

const std::string kRuns(kProvenanceRuns);

/// The dimension of the arrays. Axes of the grid are not used, because one may have the name of a
/// fact.
void WriteRuns(hdf5::Group& group, const std::vector<std::string>& ids) {
  hdf5::Dataset runs = group.CreateDataset({kRuns, hdf5::Type::kText, {ids.size()}, {}, 0});
  runs.WriteText(ids);
  runs.MakeScale(kRuns);
  runs.SetText("long_name", "id of a run: run_id of /run");
}

}  // namespace

void MergedProvenance::Add(const std::string& run_id,
                           const std::map<std::string, std::string>& facts) {
  for (const auto& [name, text] : facts) {
    Fact& fact = facts_[name];
    fact.by_run.resize(ids_.size(), 0);
    std::size_t place = fact.by_run.empty() ? 0 : fact.by_run.back();
    if (fact.texts[place] != text) {
      const auto [found, is_new] = fact.places.try_emplace(text, fact.texts.size());
      if (is_new) fact.texts.push_back(text);
      place = found->second;
    }
    fact.by_run.push_back(place);
  }
  ids_.push_back(run_id);
}

std::vector<std::string> MergedProvenance::TextsOf(const Fact& fact) const {
  std::vector<std::string> texts;
  for (const std::size_t place : fact.by_run) texts.push_back(fact.texts[place]);
  texts.resize(ids_.size());
  return texts;
}

hdf5::Group MergedProvenance::Write(hdf5::File& file, const Provenance& of_merging) const {
  hdf5::Group group = file.CreateGroup("provenance");
  for (const auto& [name, text] : of_merging)
    if (!facts_.contains(name)) group.SetText(name.c_str(), text);
  std::vector<hdf5::Group::Attachment> attachments;
  for (const auto& [name, fact] : facts_) {
    if (fact.by_run.size() == ids_.size() &&
        std::ranges::adjacent_find(fact.by_run, std::ranges::not_equal_to()) == fact.by_run.end()) {
      group.SetText(name.c_str(), fact.texts[fact.by_run.front()]);
      continue;
    }
    if (attachments.empty()) WriteRuns(group, ids_);
    hdf5::Dataset dataset = group.CreateDataset({name, hdf5::Type::kText, {ids_.size()}, {}, 0});
    dataset.WriteText(TextsOf(fact));
    dataset.SetText("long_name", "differs between the runs of this file");
    attachments.push_back({name, {kRuns}});
  }
  group.AttachScales(attachments);
  return group;
}

namespace {

constexpr std::uint64_t kMostObjects = 100'000'000;

/// The rows of a dataset of `width` columns; empty if there is none.
std::vector<double> ReadRows(const hdf5::File& file, const std::string& path, const char* name,
                             std::uint64_t width, std::uint64_t rows) {
  if (!file.Has(name)) return {};
  const hdf5::Dataset dataset = file.OpenDataset(name);
  const hdf5::Shape& shape = dataset.shape();
  const bool fits = dataset.type() != hdf5::Type::kText && shape.size() == 2 && shape[1] == width &&
                    shape[0] > 0 && shape[0] <= kMostObjects && (rows == 0 || shape[0] == rows);
  if (!fits)
    throw files::StoreError(
        fmt::format("{}: its `{}` should be an array of numbers with {} and {} columns", path, name,
                    rows == 0 ? "a row for each object" : fmt::format("{} rows", rows), width));
  return dataset.Read();
}

/// Puts the quaternions of a dataset into the order w, x, y, z.
void PutWFirst(const hdf5::Dataset& dataset, const std::string& path, std::vector<double>& rows) {
  std::string order = dataset.Text("order");
  std::erase_if(order, [](char c) { return c == ' ' || c == ','; });
  if (order.empty() || order == "wxyz") return;
  if (order != "xyzw")
    throw files::StoreError(fmt::format(
        "{}: the attribute `order` of its `orientation` should be `wxyz` or `xyzw`, not `{}`", path,
        dataset.Text("order")));
  for (std::size_t i = 0; i + 3 < rows.size(); i += 4)
    std::rotate(rows.begin() + static_cast<std::ptrdiff_t>(i),
                rows.begin() + static_cast<std::ptrdiff_t>(i + 3),
                rows.begin() + static_cast<std::ptrdiff_t>(i + 4));
}

}  // namespace

std::optional<PoseArrays> ReadPoseArrays(const std::filesystem::path& path) {
  const std::string name = path.string();
  try {
    const hdf5::File file = hdf5::File::Open(path);
    if (!file.Has("position")) return std::nullopt;
    PoseArrays arrays;
    arrays.position = ReadRows(file, name, "position", 3, 0);
    const std::uint64_t rows = arrays.position.size() / 3;
    arrays.orientation = ReadRows(file, name, "orientation", 4, rows);
    if (!arrays.orientation.empty())
      PutWFirst(file.OpenDataset("orientation"), name, arrays.orientation);
    arrays.linear_velocity = ReadRows(file, name, "linear_velocity", 3, rows);
    arrays.angular_velocity = ReadRows(file, name, "angular_velocity", 3, rows);
    return arrays;
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: it is not HDF5 that can be read: {}", name, error.what()));
  }
}

}  // namespace cdb::results
