#include "runtime/results/layout.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "compiler/analysis/coverage.h"
#include "compiler/analysis/reference.h"
#include "compiler/schema/metrics.h"
#include "dsl/text/check.h"
#include "runtime/protocol/samples.h"
#include "runtime/protocol/series.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/versions.h"

namespace cdb::results {
namespace {

using hdf5::Type;

/// `run/` of `run/host`; empty in the root.
std::string GroupOf(const std::string& path) { return path.substr(0, path.rfind('/') + 1); }

/// One chunk if it fits; else the cycles are split evenly, and then the bodies.
hdf5::Shape ChunkOf(const Array& array, std::size_t outer) {
  hdf5::Shape chunk = array.shape;
  std::fill_n(chunk.begin(), outer, 1);
  for (const char* name : {"cycle", "sample", "body", "box_body", "query_row", "contact_row"}) {
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
            {"scale", sampled.is_log ? kLogScale : "linear"},
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
    Describe(array, series.unit,
             fmt::format("{}{}", is_sampled ? "at each sample: " : "", series.doc));
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
    AddCounted(kReferenceGroup, protocol::Dimension::kBody, facts_.bodies);
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

namespace {

std::string VerdictNames() {
  std::string names;
  for (const protocol::VerdictInfo& info : protocol::Verdicts())
    names.append(names.empty() ? "" : " ").append(info.name);
  return names;
}

std::string StatusNames() { return fmt::format("{}", fmt::join(kStatusNames, " ")); }

/// The count that was measured as a real number; -1 if it was not measured.
double CountOrNone(double value) {
  return std::isnan(value) ? -1 : std::min(value, double{std::numeric_limits<std::int32_t>::max()});
}

/// Adds the scalars that the worker measures.
std::vector<RunNumber> WithScalars(std::vector<RunNumber> numbers) {
  for (const schema::RunScalarInfo& info : schema::kRunScalars)
    numbers.push_back({std::string(kRunGroup) + std::string(info.name),
                       info.is_count ? Type::kInt32 : Type::kFloat64, std::string(info.unit),
                       std::string(info.doc), info.is_count ? -1 : kNaN,
                       [&info](const RunResult& r) {
                         const double value = r.scalars.*info.value;
                         return info.is_count ? CountOrNone(value) : value;
                       }});
  return numbers;
}

/// The values of a series of counts that are not the fill value; empty if it was not recorded.
std::vector<std::int32_t> CountsOf(const RunResult& result, std::string_view name) {
  std::vector<std::int32_t> counts;
  for (const auto& [series, bytes] : result.series) {
    if (series->name != name) continue;
    counts.resize(bytes.size() / sizeof(std::int32_t));
    std::memcpy(counts.data(), bytes.data(), bytes.size());
  }
  std::erase_if(counts, [](std::int32_t count) { return count < 0; });
  return counts;
}

/// The questions that the scene leaves open, and those that the run did.
std::string UncheckedOf(const plan::Scene& scene, const RunResult& result) {
  std::string text = UncheckedText(analysis::CoverageOf(scene));
  const auto add = [&](std::string_view question) {
    text.append(text.empty() ? "" : "; ").append(question);
  };
  if (const auto counts = CountsOf(result, "unfollowed");
      std::ranges::any_of(counts, [](std::int32_t count) { return count > 0; }))
    add("passing: some pairs of objects could not be followed");
  if (const auto counts = CountsOf(result, "unjudged_impacts");
      !counts.empty() && counts.back() > 0 &&
      analysis::IsChecked(analysis::Question::kImpacts, scene))
    add("impacts: some impacts could not be judged");
  return text;
}

double ErrorOf(const RunResult& result, const std::string& name) {
  const auto found = result.errors.values.find(name);
  return found == result.errors.values.end() || found->second.size() != 1 ? kNaN : found->second[0];
}

/// Adds the arrays of /accuracy for the errors that some run requests.
void AddErrors(const plan::Plan& plan, PlanFacts& facts) {
  using plan::Run;
  using R = const RunResult&;
  const auto add_as = [&](const std::string& name, const std::string& value, std::string_view unit,
                          std::string doc) {
    facts.numbers.push_back({std::string(kAccuracyGroup) + name, Type::kFloat64, std::string(unit),
                             std::move(doc), kNaN,
                             [value](const RunResult& r) { return ErrorOf(r, value); }});
  };
  const auto add = [&](const std::string& name, std::string_view unit, std::string doc) {
    add_as(name, name, unit, std::move(doc));
  };
  bool needs_truth = false;
  for (const schema::ErrorInfo* error : analysis::ErrorsOf(plan)) {
    const std::string name(error->name);
    add(name, error->unit, std::string(error->doc));
    needs_truth = needs_truth || error->needs_truth;
    if (error->needs_truth)
      add(name + "_floor", error->unit,
          "the same between the reference and its twin: a smaller error is not "
          "significant");
    facts.error_series.push_back({error->series, "", protocol::SeriesType::kFloat64,
                                  protocol::SeriesShape::kSample, error->unit, error->doc});
  }
  if (needs_truth)
    add("horizon", "s",
        "simulated time up to which the trajectories of the reference stay predictable");
  // If an axis is named `timestep`, this group has that dimension.
  add_as("step_size", "timestep", "s", "simulated time of a cycle");
  facts.texts.push_back({std::string(kAccuracyGroup) + "truth",
                         "ground truth of the errors: a closed form, or the id of a reference",
                         [](const Run&, R r) { return r.errors.truth; }});
  facts.texts.push_back({std::string(kAccuracyGroup) + "message",
                         "why some error of the run has no value",
                         [](const Run&, R r) { return r.errors.message; }});
}

/// Checked before the first run, because the results could not be stored.
void CheckAxisNames(const plan::Plan& plan) {
  for (const plan::Axis& axis : plan.axes)
    if (const auto clash = schema::FindNameClash(axis.name, analysis::ErrorsOf(plan)))
      throw files::StoreError(
          fmt::format("{}: the axis '{}' has the name of {}; nothing was written: give the axis "
                      "another name in "
                      "{} and plan again",
                      plan.benchmark, axis.name, *clash,
                      plan.source.empty() ? "the scenario" : "'" + plan.source + "'"));
}

std::uint64_t MaxQueries(const plan::Plan& plan) {
  std::uint64_t most = 0;
  for (const plan::Run& run : plan.Bounds()) most = std::max(most, run.scene.QueryCount());
  return most;
}

}  // namespace

PlanFacts::PlanFacts(const plan::Plan& plan)
    : sha256(plan.Sha256()),
      cycles(std::max<std::uint64_t>(1, plan.MaxCycles())),
      bodies(std::max<std::uint64_t>(1, plan.MaxObjects())),
      box_bodies(std::max<std::uint64_t>(1, analysis::MaxBodyCount(plan))),
      queries(std::max<std::uint64_t>(1, MaxQueries(plan))),
      poses(plan.Records("poses")),
      boxes(plan.Records("boxes")),
      contacts(plan.Records("contacts")),
      answers(plan.Records("queries")) {
  CheckAxisNames(plan);
  for (const plan::Axis& axis : plan.axes) integer_axes.push_back(axis.IsInteger());
  series = protocol::RecordedSeries(plan);
  numbers = RunNumbers();
  texts = RunTexts();
  for (const plan::Run& run : plan.Bounds()) {
    if (const auto sampling = analysis::SamplingOf(run.scene)) {
      samples = std::max(samples, sampling->count);
      interval_s = sampling->interval_s;
    }
  }
  if (samples > 0) AddErrors(plan, *this);
}

bool IsRunFact(std::string_view name) {
  const std::string path = std::string(kRunGroup) + std::string(name);
  return std::ranges::find(RunNumbers(), path, &RunNumber::name) != RunNumbers().end() ||
         std::ranges::find(RunTexts(), path, &RunText::name) != RunTexts().end();
}

const std::vector<ReferenceArray>& ReferenceArrays() {
  static const std::vector<ReferenceArray> kArrays = {
      {"role",
       Type::kText,
       {"reference"},
       "",
       "reference, or twin: the run with another time step that shows how far it can be trusted"},
      {"status", Type::kInt8, {"reference"}, "", "how the run ended", StatusNames},
      {"message", Type::kText, {"reference"}, "", "why it did not end well, or is not sound"},
      {"verdict",
       Type::kText,
       {"reference"},
       "",
       "how a reference ended as physics: cdb doc verdicts"},
      {"state_hash",
       Type::kText,
       {"reference"},
       "",
       "hash of every body's state after the last cycle"},
      {"host", Type::kText, {"reference"}, "", "the machine that it ran on"},
      {"run_text", Type::kText, {"reference"}, "", "all that decides the run, as YAML"},
      {"states",
       Type::kFloat64,
       {"reference", "sample", "body", "state"},
       "",
       "state of every object at every sample"},
      {"observables",
       Type::kFloat64,
       {"reference", "sample", "observable"},
       "",
       "sums and extremes over all objects at every sample"},
  };
  return kArrays;
}

const std::vector<RunNumber>& RunNumbers() {
  using R = const RunResult&;
  static const std::vector<RunNumber> kNumbers = WithScalars({
      {"status", Type::kInt8, "", "how the run ended", 0,
       [](R r) { return static_cast<double>(r.status); }, StatusNames},
      {"verdict", Type::kInt8, "", "how the run ended as physics: cdb doc verdicts", 0,
       [](R r) { return static_cast<double>(r.judgement.verdict); }, VerdictNames},
      {"first_bad_cycle", Type::kInt32, "",
       "first recorded cycle at which the verdict applies; -1: none", -1,
       [](R r) { return static_cast<double>(r.judgement.first_bad_cycle); }},
      {"bad_objects", Type::kInt32, "",
       "number of objects, or pairs of them, to which the verdict applies; -1: it applies to none",
       -1, [](R r) { return static_cast<double>(r.judgement.bad_objects); }},
      {"n_cycles", Type::kInt32, "", "number of cycles that ran; -1: there is no run", -1,
       [](R r) { return static_cast<double>(r.n_cycles); }},
      {"run/started", Type::kFloat64, "seconds since 1970-01-01 00:00:00", "when the run began",
       kNaN, [](R r) { return r.started_s; }},
      {"run/load_average", Type::kFloat64, "",
       "the machine's one-minute load average when the run began", kNaN,
       [](R r) { return r.load; }},
      {"run/noise", Type::kInt8, "", "whether the run had the machine to itself: cdb doc noise", 0,
       [](R r) { return static_cast<double>(r.noise.noise); },
       [] { return fmt::format("{}", fmt::join(machine::NoiseNames(), " ")); }},
  });
  return kNumbers;
}

const std::vector<RunText>& RunTexts() {
  using plan::Run;
  using R = const RunResult&;
  static const std::vector<RunText> kTexts = {
      {"run/state_hash",
       "hash of every body's position, orientation and velocities after the last cycle",
       [](const Run&, R r) { return r.state_hash; }},
      {"run/run_id", "hash of all that decides the run's result; its name in the journal",
       [](const Run& run, R) { return run.id; }},
      {"run/host", "the machine that the run ran on", [](const Run&, R r) { return r.host; }},
      {"run/message", "why the run did not end well, or the first pair that its detector missed",
       [](const Run&, R r) { return r.message; }},
      {"run/criterion", "the series that shows why the verdict is not stable",
       [](const Run&, R r) { return r.judgement.criterion; }},
      {"run/noise_cause", "what disturbed a noisy run",
       [](const Run&, R r) { return r.noise.why; }},
      {"run/omitted", "parts of the engine that the run omitted, separated by spaces",
       [](const Run&, R r) { return r.omitted; }},
      {"run/needs", "decision about each part of the engine and its reason, one line each",
       [](const Run&, R r) { return r.decisions; }},
      {"run/checked", "questions that the verdict answers: cdb doc verdicts",
       [](const Run& run, R) { return CheckedText(analysis::CoverageOf(run.scene)); }},
      {"run/unchecked", "questions that the verdict leaves open, each with the reason",
       [](const Run& run, R r) { return UncheckedOf(run.scene, r); }},
  };
  return kTexts;
}

namespace {

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
