#include "runtime/results/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "dsl/text/check.h"
#include "runtime/protocol/series.h"
#include "runtime/results/hdf5/file.h"

namespace cdb::results {
namespace {

using hdf5::Type;

/// `run/` of `run/host`; empty in the root.
std::string GroupOf(const std::string& path) { return path.substr(0, path.rfind('/') + 1); }

/// One chunk if it fits; else the cycles are split evenly, and then the bodies.
hdf5::Shape ChunkOf(const Array& array, std::size_t outer) {
  hdf5::Shape chunk = array.shape;
  std::fill_n(chunk.begin(), outer, 1);
  for (const char* name :
       {"cycle", "sample", "body", "box_body", "query_row", "contact_row", "vertex"}) {
    const auto found = std::ranges::find(array.dimensions, GroupOf(array.name) + name);
    if (found == array.dimensions.end()) continue;
    hdf5::SplitEvenly(chunk, static_cast<std::size_t>(found - array.dimensions.begin()),
                      hdf5::ItemBytes(array.type));
  }
  return chunk;
}

class Maker {
 public:
  Maker(const plan::Plan& plan, const PlanFacts& facts) : plan_(plan), facts_(facts) {}

  Layout Make(std::uint64_t contact_rows) {
    CheckRank();
    AddGrid("");
    for (const Dimension& dimension : layout_.dimensions) layout_.grid.push_back(dimension.size);
    AddLabelled(protocol::Dimension::kPhase);
    AddCounted("", protocol::Dimension::kCycle, facts_.cycles);
    if (facts_.poses) AddCounted("", protocol::Dimension::kBody, facts_.bodies);
    if (facts_.poses) AddLabelled(protocol::Dimension::kPose);
    if (facts_.boxes) AddBoxDimensions();
    if (std::ranges::any_of(facts_.series, [](const auto* series) { return series->of_queries; }))
      AddQueryDimensions();
    if (HasSeriesOf(protocol::SeriesShape::kCounter)) AddLabelled(protocol::Dimension::kCounter);
    if (HasSeriesOf(protocol::SeriesShape::kVertex)) {
      AddCounted("", protocol::Dimension::kVertex, facts_.nodes);
      AddLabelled(protocol::Dimension::kCoordinate);
    }
    if (facts_.contacts) AddContactDimensions(contact_rows);
    AddGrid(std::string(kRunGroup));
    for (std::size_t i = 0; i < plan_.axes.size(); ++i)
      if (!plan_.axes[i].sampled.empty()) AddColumns(plan_.axes[i], facts_.integer_axes[i]);
    const bool has_errors = facts_.samples > 0;
    if (has_errors) AddGrid(std::string(kAccuracyGroup));
    if (has_errors) AddSampleDimension(std::string(kAccuracyGroup));
    const bool holds_references = !plan_.references.empty();
    if (holds_references) AddReferenceDimensions();
    if (!plan_.requirements.empty()) AddRequirementDimensions();
    for (const protocol::Series* series : facts_.series) AddSeries(*series);
    if (facts_.contacts) AddContacts();
    AddRunArrays();
    for (const protocol::Series& series : facts_.error_series) AddSeries(series);
    if (holds_references) AddReferences();
    if (!plan_.requirements.empty()) AddRequirements();
    if (plan_.SearchAxis()) AddBoundaries();
    if (!plan_.RaceAxes().empty()) AddRaces();
    return std::move(layout_);
  }

 private:
  void CheckRank() const {
    // HDF5 has at most 32 dimensions.
    if (plan_.axes.size() > 28)
      throw files::StoreError(
          fmt::format("{}: {} axes are more than a result has room for (28); nothing "
                      "was written: sweep fewer parameters",
                      plan_.benchmark, plan_.axes.size()));
  }

  const Dimension& Find(const std::string& dimension) const {
    const auto found = std::ranges::find(layout_.dimensions, dimension, &Dimension::name);
    CDB_CHECK(found != layout_.dimensions.end());
    return *found;
  }

  void AddDimension(const std::string& group, Dimension dimension) {
    dimension.name = group + dimension.name;
    layout_.dimensions.push_back(std::move(dimension));
  }

  /// The axes and `rep`, for every group with arrays over the grid.
  void AddGrid(const std::string& group) {
    for (std::size_t i = 0; i < plan_.axes.size(); ++i)
      AddDimension(group, AxisDimension(plan_.axes[i], facts_.integer_axes[i]));
    AddDimension(group, Counted("rep", plan_.repeats, "timed repeat of a point"));
  }

  /// Of an axis of sampled points.
  void AddColumns(const plan::Axis& axis, bool is_integer) {
    const std::string group(kSampledGroup);
    AddDimension(group, AxisDimension(axis, is_integer));
    for (const plan::Coordinates& sampled : axis.sampled)
      layout_.columns.push_back(
          {group + sampled.name,
           group + axis.name,
           sampled.values,
           {{"long_name", fmt::format("{} at the points of {}", sampled.name, axis.name)},
            {kScaleAttribute, sampled.is_log ? kLogScale : "linear"},
            {"units", kNoUnit}},
           sampled.first,
           sampled.last});
  }

  /// Adds an array over the grid and the `inner` dimensions of its group.
  Array& Add(std::string name, Type type, const std::vector<std::string>& inner, bool over_grid) {
    const std::string group = GroupOf(name);
    Array array{std::move(name), type, {}, {}, {}, 0, false, {}, {}, nullptr};
    if (over_grid) {
      for (const plan::Axis& axis : plan_.axes) array.dimensions.push_back(group + axis.name);
      array.dimensions.push_back(group + "rep");
      array.shape = layout_.grid;
    }
    for (const std::string& dimension : inner) {
      array.dimensions.push_back(group + dimension);
      array.shape.push_back(Find(array.dimensions.back()).size);
    }
    layout_.arrays.push_back(std::move(array));
    return layout_.arrays.back();
  }

  /// Every number has a unit, and a comment if its components have different ones.
  void Describe(Array& array, std::string_view unit, std::string_view doc) const {
    array.attributes["long_name"] = doc;
    if (!unit.empty()) array.attributes["units"] = unit;
    if (unit == "bytes")
      array.attributes["comment"] = "float64, as bytes can pass the range of int32";
    if (!unit.empty() || array.type == Type::kText || !array.flags.empty()) return;
    for (const std::string& name : array.dimensions) {
      const Dimension& dimension = Find(name);
      if (dimension.units_by_label.empty()) continue;
      array.attributes["component_units"] = dimension.units_by_label;
      array.attributes["comment"] =
          fmt::format("component_units are the units along {}", name.substr(GroupOf(name).size()));
      return;
    }
    array.attributes["units"] = kNoUnit;
  }

  void AddSeries(const protocol::Series& series) {
    std::vector<std::string> inner;
    for (const protocol::Dimension dimension : protocol::DimensionsOf(series.shape))
      inner.emplace_back(protocol::InfoOf(dimension).name);
    const bool is_int = series.type == protocol::SeriesType::kInt32;
    Array& array =
        Add(std::string(series.name), is_int ? Type::kInt32 : Type::kFloat64, inner, true);
    array.chunk = ChunkOf(array, layout_.grid.size());
    array.fill = is_int ? -1 : kNaN;
    array.has_fill_value = true;
    array.series = &series;
    const bool is_sampled = series.shape == protocol::SeriesShape::kSample;
    const bool is_count = facts_.counts_instructions && series.unit == "ns";
    Describe(array, is_count ? "" : series.unit,
             fmt::format("{}{}",
                         is_sampled ? "at each sample: "
                         : is_count ? fmt::format("{} ", kInstructions)
                                    : "",
                         series.doc));
    if (series.name == "poses") array.attributes["frame"] = kPoseFrame;
    if (facts_.contacts && series.name == "contacts") {
      array.attributes.emplace("sample_dimension", "contact_row");
      array.attributes.emplace(
          "comment",
          "a cell's contacts are in contact_* one cycle after the other, from row contact_first");
    }
  }

  void AddCounted(const std::string& group, protocol::Dimension dimension, std::uint64_t size) {
    const protocol::DimensionInfo& info = protocol::InfoOf(dimension);
    AddDimension(group, Counted(std::string(info.name), size, std::string(info.doc)));
  }

  bool HasSeriesOf(protocol::SeriesShape shape) const {
    return std::ranges::find(facts_.series, shape, &protocol::Series::shape) != facts_.series.end();
  }

  void AddLabelled(protocol::Dimension dimension) {
    const protocol::DimensionInfo& info = protocol::InfoOf(dimension);
    AddDimension("", Labelled(std::string(info.name), {info.labels.begin(), info.labels.end()},
                              std::string(info.doc)));
    layout_.dimensions.back().units_by_label = info.units;
  }

  void AddBoxDimensions() {
    AddCounted("", protocol::Dimension::kBoxBody, facts_.box_bodies);
    AddLabelled(protocol::Dimension::kBound);
    AddLabelled(protocol::Dimension::kFilter);
  }

  void AddQueryDimensions() {
    AddLabelled(protocol::Dimension::kQuery);
    if (!facts_.answers) return;
    AddCounted("", protocol::Dimension::kQueryRow, facts_.queries);
    AddLabelled(protocol::Dimension::kAnswer);
  }

  void AddSampleDimension(const std::string& group) {
    const protocol::DimensionInfo& info = protocol::InfoOf(protocol::Dimension::kSample);
    Dimension sample;
    sample.name = info.name;
    sample.size = facts_.samples;
    sample.type = Type::kFloat64;
    for (std::uint64_t i = 0; i < facts_.samples; ++i)
      sample.numbers.push_back(static_cast<double>(i) * facts_.interval_s);
    sample.attributes = {{"units", "s"}, {"long_name", std::string(info.doc)}};
    AddDimension(group, std::move(sample));
  }

  void AddReferenceDimensions() {
    std::vector<std::string> ids;
    for (const plan::Run& reference : plan_.references) ids.push_back(reference.id);
    AddDimension(kReferenceGroup, Labelled("reference", std::move(ids), "id of a reference run"));
    AddSampleDimension(kReferenceGroup);
    AddCounted(kReferenceGroup, protocol::Dimension::kBody, facts_.sampled_bodies);
    const auto add = [this](const char* name, std::span<const std::string_view> labels,
                            std::string_view units, const char* doc) {
      AddDimension(kReferenceGroup, Labelled(name, {labels.begin(), labels.end()}, doc));
      layout_.dimensions.back().units_by_label = units;
    };
    add("state", protocol::StateNames(), protocol::StateUnits(),
        "centre of mass, orientation quaternion, velocity and angular velocity");
    add("observable", protocol::ObservableNames(), protocol::ObservableUnits(),
        "energies, momentum, angular momentum, depths in sizes, and counts");
  }

  void AddReferences() {
    for (const ReferenceArray& row : ReferenceArrays()) {
      Array& array = Add(kReferenceGroup + row.name, row.type, row.dimensions, false);
      array.fill = row.type == Type::kFloat64 ? kNaN : 0;
      array.has_fill_value = row.type == Type::kFloat64;
      if (row.dimensions.size() > 1) array.chunk = ChunkOf(array, 1);
      if (row.flags != nullptr) array.flags = row.flags();
      Describe(array, row.unit, row.doc);
    }
  }

  /// The axes without `rep`: points are judged, not runs.
  void AddRequirementDimensions() {
    for (std::size_t i = 0; i < plan_.axes.size(); ++i)
      AddDimension(kRequirementsGroup, AxisDimension(plan_.axes[i], facts_.integer_axes[i]));
    std::vector<std::string> texts;
    std::string units;
    for (const plan::Requirement& requirement : plan_.requirements) {
      texts.push_back(requirement.text);
      std::string unit(requirement.figure.Unit());
      std::ranges::replace(unit, ' ', '.');
      units += fmt::format("{}{}", units.empty() ? "" : " ", unit.empty() ? kNoUnit : unit);
    }
    AddDimension(kRequirementsGroup,
                 Labelled("requirement", std::move(texts), "requirement of the scenario"));
    layout_.dimensions.back().units_by_label = std::move(units);
  }

  void AddRequirements() {
    const std::vector<std::string> one = {"requirement"};
    std::vector<std::string> all;
    for (const plan::Axis& axis : plan_.axes) all.push_back(axis.name);
    all.emplace_back("requirement");
    const auto add = [&](const char* name, Type type, const std::vector<std::string>& dimensions,
                         const char* doc) -> Array& {
      Array& array = Add(kRequirementsGroup + name, type, dimensions, false);
      if (type == Type::kFloat64) array.fill = kNaN;
      array.has_fill_value = type == Type::kFloat64;
      Describe(array, "", doc);
      return array;
    };
    add("figure", Type::kText, one, "figure that is required to be in a range");
    add("comparison", Type::kText, one, "comparison of the figure with the limit");
    add("limit", Type::kFloat64, one, "limit of the figure; of a verdict, its number");
    Array& answer = add("answer", Type::kInt8, all, "whether the point meets the requirement");
    answer.flags = "not_run cannot_tell not_met met";
    answer.attributes.erase("units");
    answer.attributes.erase("component_units");
    answer.attributes.erase("comment");
    add("value", Type::kFloat64, all, "the figure of the point");
    add("low", Type::kFloat64, all,
        "lower end of its 95 % interval over the repeats, or of the values that it may have");
    add("high", Type::kFloat64, all, "upper end of the same");
  }

  /// Over the axes without that of the search.
  void AddBoundaries() {
    const plan::Axis& searched = plan_.axes[*plan_.SearchAxis()];
    std::vector<std::string> places;
    for (std::size_t i = 0; i < plan_.axes.size(); ++i) {
      if (plan_.axes[i].search) continue;
      AddDimension(kBoundaryGroup, AxisDimension(plan_.axes[i], facts_.integer_axes[i]));
      places.push_back(plan_.axes[i].name);
    }
    const auto add = [&](const char* name, Type type, std::string_view unit,
                         const std::string& doc) -> Array& {
      Array& array = Add(kBoundaryGroup + name, type, places, false);
      if (type == Type::kFloat64) array.fill = kNaN;
      array.has_fill_value = type == Type::kFloat64;
      Describe(array, unit, doc);
      return array;
    };
    Array& outcome = add("outcome", Type::kInt8, "",
                         fmt::format("what the search along {} found", searched.name));
    outcome.flags = "not_known between at_first nowhere uncertain";
    outcome.attributes.erase("units");
    add("value", Type::kFloat64, searched.unit,
        fmt::format("value of {} from which {} holds: the middle of two neighbouring values",
                    searched.name, searched.search->until.text));
    add("low", Type::kFloat64, searched.unit, "lower of the values between which it is");
    add("high", Type::kFloat64, searched.unit, "upper of the values between which it is");
    add("changes", Type::kInt32, "",
        "changes of the condition between neighbouring values that were run; above 1: not "
        "monotone");
    add("probes", Type::kInt32, "", "values that were run");
  }

  /// Over all axes: for each configuration of each race.
  void AddRaces() {
    std::vector<std::string> points;
    for (std::size_t i = 0; i < plan_.axes.size(); ++i) {
      AddDimension(kRaceGroup, AxisDimension(plan_.axes[i], facts_.integer_axes[i]));
      points.push_back(plan_.axes[i].name);
    }
    const plan::Race& race = *plan_.axes[plan_.RaceAxes()[0]].race;
    const auto add = [&](const char* name, Type type, const std::string& doc) -> Array& {
      Array& array = Add(kRaceGroup + name, type, points, false);
      if (type != Type::kInt8) {
        array.fill = type == Type::kFloat64 ? kNaN : -1;
        array.has_fill_value = true;
      }
      Describe(array, "", doc);
      return array;
    };
    Array& outcome = add("outcome", Type::kInt8, "how the configuration did in its race");
    outcome.flags = "not_known won dropped tied open failed";
    outcome.attributes.erase("units");
    add("repeats", Type::kInt32, "repeats by which that was decided");
    add("against", Type::kInt32,
        "the configuration with which it is compared: its index among all combinations of the "
        "values of the axes with a race, the last axis fastest");
    add("ratio", Type::kFloat64,
        fmt::format("median over the repeats of {}, divided by that of the configuration it is "
                    "compared with",
                    race.by.Text()));
    add("low", Type::kFloat64, "lower bound of the ratio, of 95 % over the whole race");
    add("high", Type::kFloat64, "upper bound of the same");
  }

  void AddContactDimensions(std::uint64_t rows) {
    Dimension contact;
    contact.name = "contact_row";
    contact.size = rows;
    AddDimension("", std::move(contact));
    AddDimension("", Labelled("contact_side", {"a", "b"}, "body of a contact"));
    AddDimension("", Labelled("xyz", {"x", "y", "z"}, "component of a vector"));
  }

  void AddContacts() {
    const auto add = [this](const char* name, Type type, std::vector<std::string> inner,
                            const char* unit, const char* doc) {
      inner.insert(inner.begin(), "contact_row");
      Array& array = Add(name, type, inner, false);
      // An array without elements cannot have chunks.
      if (array.shape[0] > 0) array.chunk = ChunkOf(array, 0);
      array.fill = type == Type::kInt32 ? -1 : kNaN;
      array.has_fill_value = true;
      Describe(array, unit, doc);
    };
    add("contact_body", Type::kInt32, {"contact_side"}, "",
        "index of the object; the walls -x +x -y +y -z +z follow the last object");
    add("contact_point", Type::kFloat64, {"xyz"}, "m", "contact point on body a");
    add("contact_normal", Type::kFloat64, {"xyz"}, "", "unit normal from body b to body a");
    add("contact_distance", Type::kFloat64, {}, "m", "distance of the bodies; negative in overlap");
    Array& first = Add("contact_first", Type::kFloat64, {}, true);
    first.fill = kNaN;
    first.has_fill_value = true;
    Describe(first, "",
             "the run's first row in contact_*; float64, as rows pass the range of int32; none "
             "recorded: no value");
  }

  void AddRunArrays() {
    for (const RunNumber& number : facts_.numbers) {
      Array& array = Add(number.name, number.type, {}, true);
      array.fill = number.missing;
      // Flags have a value for it, and xarray turns arrays with a fill value into floats.
      array.has_fill_value = number.flags == nullptr;
      if (number.flags != nullptr) array.flags = number.flags();
      Describe(array, number.unit, number.doc);
    }
    for (const RunText& text : facts_.texts)
      Describe(Add(text.name, Type::kText, {}, true), "", text.doc);
  }

  const plan::Plan& plan_;
  const PlanFacts& facts_;
  Layout layout_;
};

}  // namespace

const Array& Layout::Get(std::string_view name) const {
  const auto found = std::ranges::find(arrays, name, &Array::name);
  CDB_CHECK(found != arrays.end());
  return *found;
}

hdf5::Shape CellAt(const hdf5::Shape& grid, std::size_t index) {
  hdf5::Shape cell(grid.size());
  for (std::size_t i = grid.size(); i-- > 0; index /= grid[i]) cell[i] = index % grid[i];
  return cell;
}

std::uint64_t ChunksOfCell(const Array& array, std::size_t outer) {
  std::uint64_t count = 1;
  for (std::size_t d = outer; d < array.shape.size(); ++d)
    count *= (array.shape[d] + array.chunk[d] - 1) / array.chunk[d];
  return count;
}

hdf5::Shape ChunkStart(const Array& array, const hdf5::Shape& cell, std::uint64_t index) {
  hdf5::Shape start = cell;
  start.resize(array.shape.size());
  for (std::size_t d = array.shape.size(); d-- > cell.size();) {
    const std::uint64_t n = (array.shape[d] + array.chunk[d] - 1) / array.chunk[d];
    start[d] = index % n * array.chunk[d];
    index /= n;
  }
  return start;
}

Layout MakeLayout(const plan::Plan& plan, const PlanFacts& facts, std::uint64_t contact_rows) {
  return Maker(plan, facts).Make(contact_rows);
}

bool IsByClock(std::string_view dataset) {
  if (const auto* series = schema::FindSeries(dataset)) return series->unit == "ns";
  return std::ranges::any_of(schema::kRunScalars, [&](const schema::RunScalarInfo& scalar) {
    return scalar.name == dataset && scalar.by_clock;
  });
}

}  // namespace cdb::results
