#include "runtime/store/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "compiler/plan/capacity.h"
#include "compiler/plan/reference.h"
#include "compiler/plan/requested_errors.h"
#include "compiler/schema/metrics.h"
#include "dsl/check.h"
#include "runtime/store/hdf5/chunks.h"

namespace cdb::store {
namespace {

using hdf5::Type;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Whole if that fits; else the cycles are split evenly, and then the bodies.
hdf5::Shape ChunkOf(const Array& array, std::size_t outer) {
  hdf5::Shape chunk = array.shape;
  std::fill_n(chunk.begin(), outer, 1);
  for (const char* name : {"cycle", "sample", "body", "box_body", "contact"}) {
    const auto found = std::ranges::find(array.dimensions, name);
    if (found == array.dimensions.end()) continue;
    hdf5::SplitEvenly(chunk, static_cast<std::size_t>(found - array.dimensions.begin()),
                      hdf5::ItemBytes(array.type));
  }
  return chunk;
}

class Maker {
 public:
  Maker(const PlanFacts& facts, const plan::Run* run) : facts_(facts), run_(run) {}

  Layout Make(const plan::Plan& plan, std::uint64_t contact_rows) {
    for (std::size_t i = 0; i < plan.axes.size(); ++i) {
      layout_.dimensions.push_back(AxisDimension(plan.axes[i], run_, i));
      grid_.push_back("");  // named below, when the other names are known
    }
    // HDF5 has at most 32 dimensions.
    if (plan.axes.size() > 28)
      throw StoreError(
          fmt::format("{}: {} axes are more than a result has room for (28); nothing "
                      "was written: sweep fewer parameters",
                      plan.benchmark, plan.axes.size()));
    Dimension rep = Counted("rep", run_ != nullptr ? 1 : plan.repeats, "timed repeat of a point");
    if (run_ != nullptr) rep.numbers = {static_cast<double>(run_->rep)};
    layout_.dimensions.push_back(std::move(rep));
    grid_.push_back("rep");
    for (const Dimension& dimension : layout_.dimensions) layout_.grid.push_back(dimension.size);
    AddLabelled(measure::Dimension::kPhase);
    AddCounted(measure::Dimension::kCycle, facts_.cycles);
    const bool holds_references = run_ == nullptr && !plan.references.empty();
    if (facts_.poses || holds_references) AddCounted(measure::Dimension::kBody, facts_.bodies);
    if (facts_.poses) AddLabelled(measure::Dimension::kPose);
    if (facts_.boxes) AddBoxDimensions();
    if (facts_.contacts) AddContactDimensions(contact_rows);
    if (facts_.samples > 0) AddSampleDimension();
    if (holds_references) AddReferenceDimensions(plan);
    for (const measure::Series* series : facts_.series) AddSeries(*series);
    if (facts_.contacts) AddContacts();
    AddRunArrays();
    for (const measure::Series& series : facts_.error_series) AddSeries(series);
    if (holds_references) AddReferences();
    NameAxes(plan);
    return std::move(layout_);
  }

 private:
  std::uint64_t Extent(const std::string& dimension) const {
    // From the end, as the axes come first and one may be called the same until NameAxes.
    const auto found = std::ranges::find(layout_.dimensions.rbegin(), layout_.dimensions.rend(),
                                         dimension, &Dimension::name);
    CDB_CHECK(found != layout_.dimensions.rend());
    return found->size;
  }

  /// An array over the grid and `inner` dimensions.
  Array& Add(std::string name, Type type, const std::vector<std::string>& inner, bool over_grid) {
    Array array{std::move(name), type, {}, {}, {}, 0, false, {}, {}, nullptr};
    if (over_grid) {
      array.dimensions = grid_;
      array.shape = layout_.grid;
    }
    for (const std::string& dimension : inner) {
      array.dimensions.push_back(dimension);
      array.shape.push_back(Extent(dimension));
    }
    layout_.arrays.push_back(std::move(array));
    return layout_.arrays.back();
  }

  void AddSeries(const measure::Series& series) {
    std::vector<std::string> inner;
    for (const measure::Dimension dimension : measure::DimensionsOf(series.shape))
      inner.emplace_back(measure::InfoOf(dimension).name);
    const bool is_int = series.type == measure::SeriesType::kInt32;
    Array& array =
        Add(std::string(series.name), is_int ? Type::kInt32 : Type::kFloat64, inner, true);
    array.chunk = ChunkOf(array, layout_.grid.size());
    array.fill = is_int ? -1 : kNaN;
    array.has_fill_value = true;
    array.series = &series;
    array.attributes = {{"units", std::string(series.unit)},
                        {"long_name", std::string(series.doc)}};
    if (facts_.contacts && series.name == "contacts") {
      array.attributes.emplace("sample_dimension", "contact");
      array.attributes.emplace(
          "comment",
          "a cell's contacts stand in contact_* one cycle after the other, from row contact_first");
    }
  }

  void AddCounted(measure::Dimension dimension, std::uint64_t size) {
    const measure::DimensionInfo& info = measure::InfoOf(dimension);
    layout_.dimensions.push_back(Counted(std::string(info.name), size, std::string(info.doc)));
  }

  void AddLabelled(measure::Dimension dimension) {
    const measure::DimensionInfo& info = measure::InfoOf(dimension);
    layout_.dimensions.push_back(Labelled(
        std::string(info.name), {info.labels.begin(), info.labels.end()}, std::string(info.doc)));
  }

  void AddBoxDimensions() {
    AddCounted(measure::Dimension::kBoxBody, facts_.box_bodies);
    AddLabelled(measure::Dimension::kBound);
    AddLabelled(measure::Dimension::kFilter);
  }

  void AddSampleDimension() {
    const measure::DimensionInfo& info = measure::InfoOf(measure::Dimension::kSample);
    Dimension sample{std::string(info.name), facts_.samples, Type::kFloat64, {}, {}, {}};
    for (std::uint64_t i = 0; i < facts_.samples; ++i)
      sample.numbers.push_back(static_cast<double>(i) * facts_.interval_s);
    sample.attributes = {{"units", "s"}, {"long_name", std::string(info.doc)}};
    layout_.dimensions.push_back(std::move(sample));
  }

  void AddReferenceDimensions(const plan::Plan& plan) {
    std::vector<std::string> ids;
    for (const plan::Run& reference : plan.references) ids.push_back(reference.id);
    layout_.dimensions.push_back(Labelled("reference", std::move(ids), "id of a reference run"));
    layout_.dimensions.push_back(Labelled(
        "state", {measure::StateNames().begin(), measure::StateNames().end()},
        "centre of mass, m, orientation quaternion, velocity, m/s, and angular velocity, rad/s"));
    layout_.dimensions.push_back(Labelled(
        "observable", {measure::ObservableNames().begin(), measure::ObservableNames().end()},
        "energies, J; momentum, kg m/s; angular momentum, kg m^2/s; depths in sizes; counts"));
  }

  /// Filled by the merge alone; a reference's shard is of another kind (reference_shard.h).
  void AddReferences() {
    for (const ReferenceArray& row : ReferenceArrays()) {
      Array& array = Add(kReferenceGroup + row.name, row.type, row.dimensions, false);
      array.fill = row.type == Type::kFloat64 ? kNaN : 0;
      array.has_fill_value = row.type == Type::kFloat64;
      if (row.dimensions.size() > 1) array.chunk = ChunkOf(array, 1);
      array.attributes = {{"units", row.unit}, {"long_name", row.doc}};
      if (row.flags != nullptr) array.flags = row.flags();
    }
  }

  void AddContactDimensions(std::uint64_t rows) {
    layout_.dimensions.push_back({"contact", rows, Type::kInt32, {}, {}, {}});
    layout_.dimensions.push_back(Labelled("contact_side", {"a", "b"}, "body of a contact"));
    layout_.dimensions.push_back(Labelled("xyz", {"x", "y", "z"}, "component of a vector"));
  }

  void AddContacts() {
    const auto add = [this](const char* name, Type type, std::vector<std::string> inner,
                            const char* unit, const char* doc) {
      inner.insert(inner.begin(), "contact");
      Array& array = Add(name, type, inner, false);
      // An array without elements cannot have chunks.
      if (array.shape[0] > 0) array.chunk = ChunkOf(array, 0);
      array.fill = type == Type::kInt32 ? -1 : kNaN;
      array.has_fill_value = true;
      array.attributes = {{"units", unit}, {"long_name", doc}};
    };
    add("contact_body", Type::kInt32, {"contact_side"}, "",
        "index of the object; the walls -x +x -y +y -z +z follow the last object");
    add("contact_point", Type::kFloat64, {"xyz"}, "m", "contact point on body a");
    add("contact_normal", Type::kFloat64, {"xyz"}, "", "unit normal from body b to body a");
    add("contact_distance", Type::kFloat64, {}, "m", "distance of the bodies; negative in overlap");
    Array& first = Add("contact_first", Type::kFloat64, {}, true);
    first.fill = kNaN;
    first.has_fill_value = true;
    first.attributes = {{"long_name", "the run's first row in contact_*; none recorded: no value"}};
  }

  void AddRunArrays() {
    for (const RunNumber& number : facts_.numbers) {
      Array& array = Add(number.name, number.type, {}, true);
      array.fill = number.missing;
      array.has_fill_value = number.type == Type::kFloat64;
      array.attributes = {{"units", number.unit}, {"long_name", number.doc}};
      if (number.flags != nullptr) array.flags = number.flags();
    }
    for (const RunText& text : facts_.texts)
      Add(text.name, Type::kText, {}, true).attributes = {{"long_name", text.doc}};
  }

  /// An axis that is called like something else of the file (`cases load`) gets `_axis`; its
  /// attribute `axis_name` keeps the name that the scenario gave it.
  void NameAxes(const plan::Plan& plan) {
    std::set<std::string> taken = {"provenance", "accuracy"};
    for (const Array& array : layout_.arrays) taken.insert(array.name);
    for (std::size_t i = plan.axes.size(); i < layout_.dimensions.size(); ++i)
      taken.insert(layout_.dimensions[i].name);
    for (std::size_t i = 0; i < plan.axes.size(); ++i) {
      std::string& name = layout_.dimensions[i].name;
      while (!taken.insert(name).second) name += "_axis";
      for (Array& array : layout_.arrays)
        if (array.dimensions.size() >= grid_.size() && array.dimensions[i].empty())
          array.dimensions[i] = name;
    }
  }

  const PlanFacts& facts_;
  const plan::Run* run_;
  Layout layout_;
  std::vector<std::string> grid_;
};

std::string VerdictNames() {
  std::string names;
  for (const measure::VerdictInfo& info : measure::Verdicts())
    names.append(names.empty() ? "" : " ").append(info.name);
  return names;
}

std::string StatusNames() { return fmt::format("{}", fmt::join(kStatusNames, " ")); }

/// Adds what the worker measures.
std::vector<RunNumber> WithScalars(std::vector<RunNumber> numbers) {
  for (const measure::RunScalarInfo& info : measure::AllRunScalars())
    numbers.push_back({std::string(info.name), Type::kFloat64, std::string(info.unit),
                       std::string(info.doc), kNaN,
                       [value = info.value](const RunResult& r) { return r.scalars.*value; }});
  return numbers;
}

double ErrorOf(const RunResult& result, const std::string& name) {
  const auto found = result.errors.values.find(name);
  return found == result.errors.values.end() || found->second.size() != 1 ? kNaN : found->second[0];
}

/// The arrays of /accuracy, as the errors that some run asks for want them.
void AddErrors(const plan::Plan& plan, PlanFacts& facts) {
  using plan::Run;
  using R = const RunResult&;
  const auto add = [&](const std::string& name, std::string_view unit, std::string doc) {
    facts.numbers.push_back({std::string(kAccuracyGroup) + name, Type::kFloat64, std::string(unit),
                             std::move(doc), kNaN,
                             [name](const RunResult& r) { return ErrorOf(r, name); }});
  };
  bool needs_truth = false;
  for (const schema::ErrorInfo* error : plan::ErrorsOf(plan)) {
    const std::string name(error->name);
    add(name, error->unit, std::string(error->doc));
    needs_truth = needs_truth || error->needs_truth;
    if (error->needs_truth)
      add(name + "_floor", error->unit,
          "the same between the reference and its twin: an error below it says nothing");
    facts.error_series.push_back({error->series, "", measure::SeriesType::kFloat64,
                                  measure::SeriesShape::kSample, error->unit, error->doc});
  }
  if (needs_truth)
    add("horizon", "s", "simulated time from which on the reference is not sure of places itself");
  add("timestep", "s", "simulated time of a cycle, for what a simulated second takes");
  facts.texts.push_back({std::string(kAccuracyGroup) + "truth",
                         "what errors are held against: a closed form, or the id of a reference",
                         [](const Run&, R r) { return r.errors.truth; }});
  facts.texts.push_back({std::string(kAccuracyGroup) + "message",
                         "why some error of the run has no value",
                         [](const Run&, R r) { return r.errors.message; }});
}

}  // namespace

PlanFacts::PlanFacts(const plan::Plan& plan)
    : sha256(plan.Sha256()),
      cycles(std::max<std::uint64_t>(1, plan.MaxCycles())),
      bodies(std::max<std::uint64_t>(1, plan.MaxObjects())),
      box_bodies(std::max<std::uint64_t>(1, plan::MaxBodyCount(plan))),
      poses(plan.Records("poses")),
      boxes(plan.Records("boxes")),
      contacts(plan.Records("contacts")) {
  for (const measure::Series& row : measure::AllSeries())
    if (row.IsRecordedBy(plan)) series.push_back(&row);
  numbers = RunNumbers();
  texts = RunTexts();
  for (const plan::Run& run : plan.runs) {
    if (const auto sampling = plan::SamplingOf(run.scene)) {
      samples = std::max(samples, sampling->count);
      interval_s = sampling->interval_s;
    }
  }
  if (samples > 0) AddErrors(plan, *this);
}

const std::vector<ReferenceArray>& ReferenceArrays() {
  static const std::vector<ReferenceArray> kArrays = {
      {"role", Type::kText, {"reference"}, "", "reference, or the twin that shows its horizon"},
      {"status", Type::kInt8, {"reference"}, "", "how the run ended", StatusNames},
      {"message", Type::kText, {"reference"}, "", "why it did not end well"},
      {"state_hash", Type::kText, {"reference"}, "", "as that of the runs"},
      {"host", Type::kText, {"reference"}, "", "the machine that it ran on"},
      {"run_text", Type::kText, {"reference"}, "", "all that decides it, as YAML"},
      {"states",
       Type::kFloat64,
       {"reference", "sample", "body", "state"},
       "",
       "of every object at every sample"},
      {"observables",
       Type::kFloat64,
       {"reference", "sample", "observable"},
       "",
       "of all objects together at every sample"},
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
      {"first_bad_cycle", Type::kInt32, "", "recorded cycle at which the verdict shows; -1: none",
       -1, [](R r) { return static_cast<double>(r.judgement.first_bad_cycle); }},
      {"n_cycles", Type::kInt32, "", "cycles that really ran", 0,
       [](R r) { return static_cast<double>(r.n_cycles); }},
      {"started", Type::kFloat64, "seconds since 1970-01-01 00:00:00", "when the run began", kNaN,
       [](R r) { return r.started_s; }},
      {"load", Type::kFloat64, "", "the machine's one-minute load average when the run began", kNaN,
       [](R r) { return r.load; }},
      {"noise", Type::kInt8, "", "whether the run had the machine to itself: cdb doc noise", 0,
       [](R r) { return static_cast<double>(r.noise.noise); },
       [] { return fmt::format("{}", fmt::join(measure::NoiseNames(), " ")); }},
  });
  return kNumbers;
}

const std::vector<RunText>& RunTexts() {
  using plan::Run;
  using R = const RunResult&;
  static const std::vector<RunText> kTexts = {
      {"state_hash", "of every body's position, orientation and velocities after the last cycle",
       [](const Run&, R r) { return r.state_hash; }},
      {"run_id", "hash of all that decides the run's result; the name of its shard",
       [](const Run& run, R) { return run.id; }},
      {"host", "the machine that the run ran on", [](const Run&, R r) { return r.host; }},
      {"message", "why the run did not end well", [](const Run&, R r) { return r.message; }},
      {"noise_cause", "what disturbed a noisy run", [](const Run&, R r) { return r.noise.why; }},
      {"omitted", "parts of the engine that were left out, separated by spaces",
       [](const Run&, R r) { return r.omitted; }},
      {"needs", "what became of each part of the engine and why, one line each",
       [](const Run&, R r) { return r.decisions; }},
  };
  return kTexts;
}

const Array& Layout::Get(std::string_view name) const {
  const auto found = std::ranges::find(arrays, name, &Array::name);
  CDB_CHECK(found != arrays.end());
  return *found;
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

Layout MakeLayout(const plan::Plan& plan, const PlanFacts& facts, const plan::Run* run,
                  std::uint64_t contact_rows) {
  return Maker(facts, run).Make(plan, contact_rows);
}

}  // namespace cdb::store
