#include "runtime/results/store.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <tuple>
#include <utility>

#include "compiler/schema/schema.h"
#include "runtime/results/hdf5/file.h"

namespace cdb::results {
namespace {

using hdf5::Type;

/// Separators of `labels`, in order of preference.
constexpr std::string_view kSeparators = " ;|\t\n";

/// The title, the parameter's description in the schema, or the axis' own name for a `let` or
/// `cases`.
std::string LongName(const plan::Axis& axis) {
  if (!axis.title.empty()) return axis.title;
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
  dimension.attributes.emplace("title", axis.title);
  std::string sampled;
  for (const plan::Coordinates& coordinates : axis.sampled)
    sampled.append(sampled.empty() ? "" : " ").append(coordinates.name);
  if (!sampled.empty()) dimension.attributes.emplace(kSampledAttribute, sampled);
  if (axis.race) {
    dimension.attributes.emplace(kRaceAttribute, axis.race->by.Text());
    dimension.attributes.emplace(kToleranceAttribute, schema::FormatReal(axis.race->tolerance));
  }
  if (axis.search) {
    const plan::Requirement& until = axis.search->until;
    dimension.attributes.emplace(kUntilAttribute, until.text);
    dimension.attributes.emplace(kFigureAttribute, until.figure.Text());
    dimension.attributes.emplace(kComparisonAttribute, plan::ComparisonText(until.comparison));
    dimension.attributes.emplace(kLimitAttribute, schema::FormatReal(until.limit));
    dimension.attributes.emplace(kScaleAttribute, axis.search->is_log ? kLogScale : "linear");
  }
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

/// The part of an array that a column names, as in numpy: `[:,2]`, `[2,:]`, `[0,:,4,1]`.
struct Slice {
  std::string path;
  std::vector<std::optional<std::uint64_t>> at;  ///< nullopt for `:`; empty without brackets
};

Slice SliceOf(const std::string& written) {
  Slice slice{written, {}};
  const std::size_t open = written.rfind('[');
  if (!written.ends_with(']') || open == written.npos) return slice;
  std::string inner = written.substr(open + 1, written.size() - open - 2);
  std::erase(inner, ' ');
  bool is_good = true;
  for (std::size_t begin = 0; begin <= inner.size();) {
    const std::size_t end = std::min(inner.find(',', begin), inner.size());
    const char *from = inner.data() + begin, *to = inner.data() + end;
    std::uint64_t index = 0;
    if (std::string_view(from, to) == ":") {
      slice.at.emplace_back();
    } else {
      const auto [stop, error] = std::from_chars(from, to, index);
      is_good = is_good && error == std::errc{} && stop == to;
      slice.at.emplace_back(index);
    }
    begin = end + 1;
  }
  if (!is_good || std::ranges::count(slice.at, std::optional<std::uint64_t>()) != 1)
    throw hdf5::Error(fmt::format("[{}] should be such as [:,0] or [0,:]", inner));
  slice.path = written.substr(0, open);
  return slice;
}

std::vector<double> ColumnOf(const hdf5::File& file, const std::string& written) {
  const Slice slice = SliceOf(written);
  hdf5::Numbers numbers = file.ReadNumbers(slice.path);
  const hdf5::Shape& shape = numbers.shape;
  const std::string text = fmt::format("{}", fmt::join(shape, " x "));
  if (slice.at.empty()) {
    if (std::ranges::count_if(shape, [](std::uint64_t n) { return n != 1; }) <= 1 && !shape.empty())
      return std::move(numbers.values);
    throw hdf5::Error(
        fmt::format("it has the shape {}: name a column, as in {}[:,0]", text, slice.path));
  }
  bool fits = slice.at.size() == shape.size();
  for (std::size_t i = 0; fits && i < shape.size(); ++i)
    fits = !slice.at[i] || *slice.at[i] < shape[i];
  if (!fits) throw hdf5::Error(fmt::format("its shape is {}", text));
  std::size_t first = 0, step = 1, count = 1;
  for (std::size_t i = shape.size(), stride = 1; i-- > 0; stride *= shape[i]) {
    if (slice.at[i])
      first += *slice.at[i] * stride;
    else
      std::tie(step, count) = std::pair(stride, shape[i]);
  }
  std::vector<double> column;
  for (std::size_t i = 0; i < count; ++i) column.push_back(numbers.values[first + i * step]);
  return column;
}

/// The rows of a dataset of `width` columns; empty if there is none.
std::vector<double> ReadRows(const hdf5::File& file, const std::string& path, const char* name,
                             std::uint64_t width, std::uint64_t rows) {
  if (!file.Has(name)) return {};
  const auto refuse = [&](const std::string& why) {
    throw files::StoreError(
        fmt::format("{}: its `{}` should be an array of numbers with {} and {} columns{}{}", path,
                    name, rows == 0 ? "a row for each object" : fmt::format("{} rows", rows), width,
                    why.empty() ? "" : ", but ", why));
  };
  hdf5::Numbers numbers;
  try {
    numbers = file.ReadNumbers(name);
  } catch (const hdf5::Error& error) {
    refuse(error.what());
  }
  const hdf5::Shape& shape = numbers.shape;
  const bool is_transposed = shape.size() == 2 && shape[0] == width && shape[1] != width;
  if (numbers.is_from_matlab && shape == hdf5::Shape{width, width})
    refuse(
        fmt::format("it has {0} by {0} from MATLAB, which may be transposed: name its columns, "
                    "such as columns: \"x=/{1}[0,:], y=/{1}[1,:], …\" for MATLAB's {1}(:,1), "
                    "{1}(:,2), …",
                    width, name));
  if (is_transposed && !numbers.is_from_matlab)
    refuse(fmt::format("it has {0} rows and {1} columns: write it by f[\"{2}\"] = {2}.T in Python",
                       shape[0], shape[1], name));
  if (is_transposed && numbers.is_from_matlab) {
    std::vector<double> turned(numbers.values.size());
    for (std::size_t i = 0; i < shape[1]; ++i)
      for (std::size_t k = 0; k < width; ++k)
        turned[i * width + k] = numbers.values[k * shape[1] + i];
    numbers = {{shape[1], width}, std::move(turned), false};
  }
  const bool fits = shape.size() == 2 && shape[1] == width && shape[0] > 0 &&
                    shape[0] <= kMostObjects && (rows == 0 || shape[0] == rows);
  if (!fits) refuse(fmt::format("it has the shape {}", fmt::join(shape, " x ")));
  return std::move(numbers.values);
}

/// Puts quaternions into the order w, x, y, z; `written` is the attribute `order`.
void PutWFirst(const std::string& written, const std::string& path, std::vector<double>& rows) {
  std::string order = written;
  std::erase_if(order, [](char c) { return c == ' ' || c == ','; });
  if (order.empty() || order == "wxyz") return;
  if (order != "xyzw")
    throw files::StoreError(fmt::format(
        "{}: the attribute `order` of its `orientation` should be `wxyz` or `xyzw`, not `{}`", path,
        written));
  for (std::size_t i = 0; i + 3 < rows.size(); i += 4)
    std::rotate(rows.begin() + static_cast<std::ptrdiff_t>(i),
                rows.begin() + static_cast<std::ptrdiff_t>(i + 3),
                rows.begin() + static_cast<std::ptrdiff_t>(i + 4));
}

}  // namespace

std::optional<PoseArrays> ReadPoseArrays(const std::filesystem::path& path, bool has_times) {
  const std::string name = path.string();
  try {
    const hdf5::File file = hdf5::File::Open(path);
    if (!file.Has("position") && file.Text("schema").empty())
      throw files::StoreError(
          fmt::format("{}: it has no dataset `position`, and is not a results file", name));
    if (!file.Has("position")) return std::nullopt;
    PoseArrays arrays;
    arrays.position = ReadRows(file, name, "position", 3, 0);
    const std::uint64_t rows = arrays.position.size() / 3;
    if (has_times && file.Has("time")) arrays.time = ColumnOf(file, "/time");
    if (!arrays.time.empty() && arrays.time.size() != rows)
      throw files::StoreError(fmt::format("{}: its `time` has {} values, but `position` {} rows",
                                          name, arrays.time.size(), rows));
    arrays.orientation = ReadRows(file, name, "orientation", 4, rows);
    if (!arrays.orientation.empty())
      PutWFirst(file.TextOfMember("orientation", "order"), name, arrays.orientation);
    arrays.linear_velocity = ReadRows(file, name, "linear_velocity", 3, rows);
    arrays.angular_velocity = ReadRows(file, name, "angular_velocity", 3, rows);
    return arrays;
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: it is not HDF5 that can be read: {}", name, error.what()));
  }
}

std::vector<std::vector<double>> ReadColumns(const std::filesystem::path& path,
                                             const std::vector<std::string>& written) {
  const std::string* reading = nullptr;
  try {
    const hdf5::File file = hdf5::File::Open(path);
    std::vector<std::vector<double>> columns;
    for (const std::string& name : written) {
      reading = &name;
      columns.push_back(ColumnOf(file, name));
    }
    return columns;
  } catch (const hdf5::Error& error) {
    if (reading == nullptr)
      throw files::StoreError(
          fmt::format("{}: it is not HDF5 that can be read: {}", path.string(), error.what()));
    throw files::StoreError(fmt::format("{}: `{}`: {}", path.string(), *reading, error.what()));
  }
}

std::string ArraysIn(const std::filesystem::path& path) {
  constexpr std::size_t kMost = 16;
  try {
    return fmt::format("{}", fmt::join(hdf5::File::Open(path).ListArrays(kMost), ", "));
  } catch (const hdf5::Error&) {
    return {};
  }
}

}  // namespace cdb::results
