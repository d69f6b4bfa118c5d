#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>
#include <utility>

#include "dsl/text/check.h"
#include "runtime/results/examine.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/layout.h"
#include "runtime/results/store.h"
#include "runtime/results/versions.h"

namespace cdb::results {
namespace {

constexpr std::size_t kMostPlanText = 256 << 10;

/// Empty if there is none.
std::string PlanText(const hdf5::File& file) {
  const std::string path = "provenance/plan_text";
  if (!file.Has("provenance") || !file.Has(path)) return {};
  const std::vector<std::string> texts = file.OpenDataset(path).ReadText();
  return texts.size() == 1 ? texts[0] : std::string();
}

std::vector<std::string> Words(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// Nullopt for any other text.
std::optional<double> NumberIn(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value)
                                                                  : std::nullopt;
}

/// The search along an axis; nullopt if there is none.
std::optional<plan::Search> ReadSearch(const hdf5::Dataset& axis) {
  const std::string text = axis.Text(kUntilAttribute);
  if (text.empty()) return std::nullopt;
  const auto figure = plan::FindFigure(axis.Text(kFigureAttribute));
  const auto comparison = plan::FindComparison(axis.Text(kComparisonAttribute));
  const auto limit = NumberIn(axis.Text(kLimitAttribute));
  if (!figure || !comparison || !limit)
    throw hdf5::Error(fmt::format("the search until '{}' is not one of this cdb", text));
  return plan::Search{{text, *figure, *comparison, *limit},
                      axis.Text(kScaleAttribute) == kLogScale};
}

/// The race of an axis; nullopt if there is none.
std::optional<plan::Race> ReadRace(const hdf5::Dataset& axis) {
  const std::string text = axis.Text(kRaceAttribute);
  if (text.empty()) return std::nullopt;
  const auto by = plan::FindFigure(text);
  const auto tolerance = NumberIn(axis.Text(kToleranceAttribute));
  if (!by || by->kind != plan::FigureKind::kTime || !tolerance)
    throw hdf5::Error(fmt::format("the race by '{}' is not one of this cdb", text));
  return plan::Race{*by, *tolerance};
}

}  // namespace

struct ResultFile::Impl {
  Impl(const std::filesystem::path& path, hdf5::File opened)
      : name(path.string()), file(std::move(opened)), version(ReadVersion(file, name)) {
    RequireSeal(file, path);
    sha256 = file.Text("plan_sha256");
    title = file.Text("title");
    benchmark = file.Text("benchmark");
    source = file.Text("source");
    for (const std::string& axis_name : Words(file.Text("axes"))) {
      const hdf5::Dataset dataset = file.OpenDataset(axis_name);
      plan::Axis axis{
          axis_name, dataset.Text("parameter"), dataset.Text("units"), {}, dataset.Text("title")};
      if (axis.unit == kNoUnit) axis.unit.clear();
      // Version 1 stored axes with a reserved name under another one.
      if (const std::string own = dataset.Text("axis_name"); !own.empty()) axis.name = own;
      if (dataset.type() == hdf5::Type::kText) {
        for (std::string& text : dataset.ReadText()) axis.values.emplace_back(std::move(text));
      } else {
        for (const double value : dataset.Read()) axis.values.emplace_back(value);
      }
      for (const std::string& sampled : Words(dataset.Text(kSampledAttribute))) {
        const hdf5::Dataset column = file.OpenDataset(std::string(kSampledGroup) + sampled);
        axis.sampled.push_back({sampled, column.Number(kFirstAttribute),
                                column.Number(kLastAttribute),
                                column.Text(kScaleAttribute) == kLogScale, column.Read()});
        if (axis.sampled.back().values.size() != axis.values.size())
          throw hdf5::Error(sampled + " has not one value for each point");
      }
      axis.search = ReadSearch(dataset);
      axis.race = ReadRace(dataset);
      grid.push_back(axis.values.size());
      kept.emplace_back(axis.values.size());
      std::iota(kept.back().begin(), kept.back().end(), std::size_t{0});
      axes.push_back(std::move(axis));
    }
    grid.push_back(Extent("rep"));
    cycles = Extent("cycle");
    if (file.OpenDataset("status").shape() != grid)
      throw hdf5::Error("its axes do not fit its arrays");
    CheckArrays(file, extents());
  }

  FileExtents extents() const { return {version, grid, cycles}; }

  /// The path in the file of the array that callers name `dataset`: facts of a run are named
  /// without their group, and the time step of a run has another name than a possible axis.
  std::string PathOf(std::string_view dataset) const {
    if (dataset == "accuracy/timestep") dataset = "accuracy/step_size";
    return PathIn(version, IsRunFact(dataset) ? std::string(kRunGroup) + std::string(dataset)
                                              : std::string(dataset));
  }

  std::uint64_t Extent(const char* dimension) const {
    return hdf5::Product(file.OpenDataset(dimension).shape());
  }

  std::size_t FlatIndex(const Cell& cell) const {
    CDB_CHECK(cell.at.size() + 1 == grid.size() && cell.rep < grid.back());
    std::size_t index = 0;
    for (std::size_t i = 0; i < cell.at.size(); ++i) {
      CDB_CHECK(cell.at[i] < kept[i].size());
      index = index * grid[i] + kept[i][cell.at[i]];
    }
    return index * grid.back() + cell.rep;
  }

  /// The indices of a cell in the arrays of the file.
  hdf5::Shape PlaceOf(const Cell& cell) const {
    CDB_CHECK(cell.at.size() + 1 == grid.size());
    hdf5::Shape place;
    for (std::size_t i = 0; i < cell.at.size(); ++i) place.push_back(kept[i][cell.at[i]]);
    place.push_back(cell.rep);
    return place;
  }

  /// The values of an array over the grid, read once.
  template <typename Value, typename Read>
  const Value& AtCell(std::map<std::string, std::vector<Value>, std::less<>>& arrays,
                      std::string_view dataset, const Cell& cell, Read read) {
    auto found = arrays.find(dataset);
    if (found == arrays.end()) {
      const hdf5::Dataset array = file.OpenDataset(PathOf(dataset));
      if (array.shape() != grid)
        throw hdf5::Error(fmt::format("{} is not an array over the grid", dataset));
      found = arrays.emplace(dataset, read(array)).first;
    }
    return found->second[FlatIndex(cell)];
  }

  std::string TextAt(std::string_view dataset, const Cell& cell) {
    return AtCell(texts, dataset, cell,
                  [](const hdf5::Dataset& array) { return array.ReadText(); });
  }

  double Number(std::string_view dataset, const Cell& cell) {
    return AtCell(numbers, dataset, cell, [&](const hdf5::Dataset& array) {
      std::vector<double> values = array.Read();
      CheckValues(IsRunFact(dataset) ? std::string(kRunGroup) + std::string(dataset) : dataset,
                  values, extents());
      return values;
    });
  }

  /// All values of a cell in a series, kept until the next call: chunks hold whole cells, and each
  /// is unpacked once. `inner` is the extent of the series besides the grid; 0 for any. If its last
  /// dimension is the cycle, only the cycles of the run are read: a run may have ended after few of
  /// many, and its file then holds almost nothing of the others.
  const std::vector<double>& Block(std::string_view dataset, const Cell& cell,
                                   const hdf5::Shape& inner) {
    const std::size_t index = FlatIndex(cell);
    auto found = series.find(dataset);
    if (found == series.end()) {
      hdf5::Dataset array = file.OpenDataset(std::string(dataset));
      hdf5::Shape shape = grid;
      shape.insert(shape.end(), inner.begin(), inner.end());
      const auto fits = [](std::uint64_t is, std::uint64_t wanted) {
        return wanted == 0 || is == wanted;
      };
      if (!std::ranges::equal(array.shape(), shape, fits))
        throw hdf5::Error(fmt::format("{} is not a series of that kind", dataset));
      found = series.emplace(dataset, Series{std::move(array), {}, {}}).first;
    }
    auto& [array, at, values] = found->second;
    if (at != index) {
      hdf5::Shape start = PlaceOf(cell);
      hdf5::Shape count(start.size(), 1);
      for (std::size_t d = start.size(); d < array.shape().size(); ++d)
        count.push_back(array.shape()[d]);
      if (inner.back() != 0) count.back() = CyclesOf(cell);
      start.resize(count.size(), 0);
      values = array.Read(start, count);
      CheckValues(dataset, values, extents());
      at = index;
    }
    return values;
  }

  /// The cycles of one of the rows of a series; `inner`: its dimensions before the cycle.
  std::vector<double> Row(std::string_view dataset, std::size_t row, hdf5::Shape inner,
                          const Cell& cell) {
    inner.push_back(cycles);
    return Reading([&] {
      const std::vector<double>& block = Block(dataset, cell, inner);
      const std::size_t count = CyclesOf(cell);
      CDB_CHECK((row + 1) * count <= block.size());
      const auto begin = block.begin() + static_cast<long>(row * count);
      return std::vector(begin, begin + static_cast<long>(count));
    });
  }

  /// Opens an array, once.
  hdf5::Dataset& Opened(std::string_view dataset) {
    auto found = opened_arrays.find(dataset);
    if (found == opened_arrays.end())
      found = opened_arrays.emplace(dataset, file.OpenDataset(std::string(dataset))).first;
    return found->second;
  }

  const std::vector<plan::Requirement>& Requirements() {
    if (requirements) return *requirements;
    requirements.emplace();
    const auto path = [](const char* array) { return kRequirementsGroup + array; };
    if (!file.Has(path("requirement"))) return *requirements;  // it may be the name of an axis
    Reading([&] {
      const auto written = file.OpenDataset(path("requirement")).ReadText();
      const auto figures = file.OpenDataset(path("figure")).ReadText();
      const auto comparisons = file.OpenDataset(path("comparison")).ReadText();
      const auto limits = file.OpenDataset(path("limit")).Read();
      for (std::size_t i = 0; i < written.size(); ++i) {
        const auto figure = plan::FindFigure(figures.at(i));
        const auto comparison = plan::FindComparison(comparisons.at(i));
        if (!figure || !comparison)
          throw hdf5::Error(fmt::format("the requirement '{}' is not one of this cdb", written[i]));
        requirements->push_back({written[i], *figure, *comparison, limits.at(i)});
      }
    });
    return *requirements;
  }

  std::size_t CyclesOf(const Cell& cell) {
    return static_cast<std::size_t>(
        std::clamp(Number("n_cycles", cell), 0.0, static_cast<double>(cycles)));
  }

  /// Converts errors of HDF5 to StoreError.
  template <typename Read>
  auto Reading(Read read) -> decltype(read()) {
    try {
      return read();
    } catch (const hdf5::Error& error) {
      throw files::StoreError(
          fmt::format("{}: cannot be read: {}; it was left as it is", name, error.what()));
    } catch (const std::bad_alloc&) {
      throw files::StoreError(
          fmt::format("{}: cannot be read: it needs more memory than there is; it was left as it "
                      "is: show a part of it (--select), or use another machine",
                      name));
    }
  }

  /// A fact of /provenance.
  struct Fact {
    std::string shared;                         ///< common to all runs
    std::map<std::string, std::string> by_run;  ///< by run id; empty if all runs have the same
  };
  Fact ReadFact(const std::string& fact_name) const {
    const hdf5::Group group = file.OpenGroup("provenance");
    if (!group.Has(fact_name)) return {group.Text(fact_name.c_str()), {}};
    const std::vector<std::string> all = group.OpenDataset(fact_name).ReadText();
    const std::vector<std::string> ids = group.OpenDataset(std::string(kProvenanceRuns)).ReadText();
    if (all.size() != ids.size())
      throw hdf5::Error(fmt::format("provenance/{} has another length than its runs", fact_name));
    Fact fact;
    for (std::size_t i = 0; i < ids.size(); ++i) fact.by_run.emplace(ids[i], all[i]);
    return fact;
  }

  struct Series {
    hdf5::Dataset array;
    std::optional<std::size_t> at;  ///< the cell to which `values` belong
    std::vector<double> values;
  };

  std::string name;
  hdf5::File file;
  int version;
  bool leaves_out_clock = false;
  bool has_digest = false;
  std::string sha256, title, benchmark, source;
  std::vector<plan::Axis> axes;
  hdf5::Shape grid;                            ///< of the complete file
  std::vector<std::vector<std::size_t>> kept;  ///< for each axis, indices in the complete file
  std::uint64_t cycles = 0;
  std::map<std::string, std::vector<double>, std::less<>> numbers;
  std::map<std::string, std::vector<std::string>, std::less<>> texts;
  std::optional<std::vector<plan::Requirement>> requirements;  ///< once read
  std::map<std::string, Series, std::less<>> series;
  std::map<std::string, hdf5::Dataset, std::less<>> opened_arrays;
  std::map<std::string, Fact> facts;
};

ResultFile::ResultFile(const std::filesystem::path& file, ProofOf of) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status))
    throw files::StoreError(
        fmt::format("{}: there is no such file; `cdb run` makes one", file.string()));
  if (std::filesystem::is_directory(status))
    throw files::StoreError(
        fmt::format("{}: is a folder, not a result; name the .h5 file", file.string()));
  const auto open = [&] { return std::make_unique<Impl>(file, hdf5::File::Open(file)); };
  const bool has_digest = ProveFile(file, kResultRemedy, of, [&](bool reads_values) {
    const auto opened = open();
    if (!reads_values) return;
    CheckAllValues(opened->file, opened->extents());
    // Reading a long plan takes longer than showing its results.
    const std::string text = PlanText(opened->file);
    if (of == ProofOf::kEveryValue || text.size() <= kMostPlanText)
      CheckAgainstPlan(opened->file, opened->extents(), text);
  });
  try {
    impl_ = open();
    impl_->has_digest = has_digest;
  } catch (const hdf5::Error& failed) {
    throw files::StoreError(
        fmt::format("{}: is not a whole result of cdb: {}; it was left as it is: {}", file.string(),
                    failed.what(), kResultRemedy));
  }
}

ResultFile::ResultFile(ResultFile&&) noexcept = default;
ResultFile::~ResultFile() = default;

bool ResultFile::has_digest() const { return impl_->has_digest; }
void ResultFile::CheckIsOf(const plan::Plan& plan) const {
  try {
    CheckAgainstPlan(impl_->file, impl_->extents(), plan);
  } catch (const hdf5::Error& error) {
    throw files::StoreError(fmt::format("{}: is damaged: {}; it was left as it is: {}", impl_->name,
                                        error.what(), kResultRemedy));
  }
}
const std::string& ResultFile::plan_sha256() const { return impl_->sha256; }
const std::string& ResultFile::title() const { return impl_->title; }
const std::string& ResultFile::benchmark() const { return impl_->benchmark; }
std::optional<double> ResultFile::budget_ns() const {
  const double seconds = impl_->file.Number("budget");
  return seconds > 0 ? std::optional(seconds * 1e9) : std::nullopt;
}
std::optional<double> ResultFile::frame_s() const {
  const double seconds = impl_->file.Number("frame");
  return seconds > 0 ? std::optional(seconds) : std::nullopt;
}
const std::vector<plan::Requirement>& ResultFile::requirements() const {
  return impl_->Requirements();
}
const std::string& ResultFile::source() const { return impl_->source; }
const std::vector<plan::Axis>& ResultFile::axes() const { return impl_->axes; }
void ResultFile::Select(std::size_t axis, const std::vector<std::size_t>& kept) {
  CDB_CHECK(axis < impl_->axes.size() && !kept.empty());
  // A part of its values says nothing of a search, or a race.
  if (kept.size() < impl_->axes[axis].values.size()) {
    const bool is_raced = impl_->axes[axis].race.has_value();
    impl_->axes[axis].search.reset();
    for (plan::Axis& each : impl_->axes)
      if (is_raced) each.race.reset();
  }
  std::vector<std::size_t> places;
  std::vector<plan::Coordinate> values;
  for (const std::size_t place : kept) {
    places.push_back(impl_->kept[axis].at(place));
    values.push_back(impl_->axes[axis].values[place]);
  }
  impl_->kept[axis] = std::move(places);
  impl_->axes[axis].values = std::move(values);
  for (plan::Coordinates& of : impl_->axes[axis].sampled) {
    std::vector<double> selected;
    for (const std::size_t place : kept) selected.push_back(of.values.at(place));
    of.values = std::move(selected);
  }
}

std::optional<std::vector<std::size_t>> ResultFile::SelectedPoint(
    const std::vector<std::size_t>& at) const {
  std::vector<std::size_t> selected;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const auto found = std::ranges::find(impl_->kept[i], at[i]);
    if (found == impl_->kept[i].end()) return std::nullopt;
    selected.push_back(static_cast<std::size_t>(found - impl_->kept[i].begin()));
  }
  return selected;
}

std::uint64_t ResultFile::repeats() const { return impl_->grid.back(); }
std::uint64_t ResultFile::begun_repeats() const {
  const Cell first{std::vector<std::size_t>(axes().size(), 0), 0};
  ReadStatus(first);  // also reads the array of statuses
  const std::vector<double>& statuses = impl_->numbers.at("status");
  std::uint64_t begun = 1;
  for (std::size_t i = 0; i < statuses.size(); ++i)
    if (statuses[i] != static_cast<double>(Status::kMissing) &&
        statuses[i] != static_cast<double>(Status::kSkipped))
      begun = std::max(begun, i % repeats() + 1);
  return begun;
}
std::uint64_t ResultFile::cycles() const { return impl_->cycles; }
bool ResultFile::Has(std::string_view dataset) const {
  if (impl_->leaves_out_clock && IsByClock(dataset)) return false;
  return impl_->file.Has(impl_->PathOf(dataset));
}

void ResultFile::LeaveOutClock() { impl_->leaves_out_clock = true; }

bool ResultFile::HasPosesOfOrigins() const {
  return impl_->Reading(
      [&] { return impl_->file.OpenDataset(impl_->PathOf("poses")).Text("frame") == kPoseFrame; });
}

Status ResultFile::ReadStatus(const Cell& cell) const {
  const double status = impl_->Reading([&] { return impl_->Number("status", cell); });
  if (!(status >= 0 && status < static_cast<double>(std::size(kStatusNames))))
    throw files::StoreError(
        fmt::format("{}: holds the status {}, which this cdb does not know; it was "
                    "left as it is: use the cdb that wrote it",
                    impl_->name, status));
  return static_cast<Status>(status);
}

protocol::Judgement ResultFile::ReadJudgement(const Cell& cell) const {
  if (!Has("verdict")) return {};
  return impl_->Reading([&]() -> protocol::Judgement {
    const double verdict = impl_->Number("verdict", cell);
    if (!(verdict >= 0 && verdict < static_cast<double>(protocol::Verdicts().size())))
      throw files::StoreError(
          fmt::format("{}: holds the verdict {}, which this cdb does not know; it was left as it "
                      "is: use the cdb that wrote it",
                      impl_->name, verdict));
    const bool is_sound = verdict <= static_cast<double>(protocol::Verdict::kStable);
    return {static_cast<protocol::Verdict>(verdict),
            static_cast<std::int64_t>(impl_->Number("first_bad_cycle", cell)),
            Has("bad_objects") ? static_cast<std::int64_t>(impl_->Number("bad_objects", cell)) : -1,
            is_sound || !Has("criterion") ? "" : impl_->TextAt("criterion", cell)};
  });
}

std::uint64_t ResultFile::ReadCycleCount(const Cell& cell) const {
  return impl_->Reading([&] { return std::uint64_t{impl_->CyclesOf(cell)}; });
}

std::string ResultFile::ReadText(std::string_view dataset, const Cell& cell) const {
  return impl_->Reading([&] { return impl_->TextAt(dataset, cell); });
}

double ResultFile::ReadReal(std::string_view dataset, const Cell& cell) const {
  return impl_->Reading([&] { return impl_->Number(dataset, cell); });
}

std::vector<double> ResultFile::ReadSeries(std::string_view dataset, const Cell& cell) const {
  return impl_->Reading([&] { return impl_->Block(dataset, cell, {impl_->cycles}); });
}

std::vector<double> ResultFile::ReadDuration(protocol::Phase phase, const Cell& cell) const {
  return impl_->Row("duration", protocol::IndexOf(phase), {protocol::kPhaseCount}, cell);
}

std::vector<double> ResultFile::ReadOfQueries(std::string_view dataset, schema::QueryType type,
                                              const Cell& cell) const {
  return impl_->Row(dataset, static_cast<std::size_t>(type), {protocol::kQueryTypeCount}, cell);
}

std::vector<double> ResultFile::ReadCounter(schema::Counter counter, protocol::Phase phase,
                                            const Cell& cell) const {
  const std::size_t row =
      static_cast<std::size_t>(counter) * protocol::kPhaseCount + protocol::IndexOf(phase);
  return impl_->Row("counters", row, {protocol::kCounterCount, protocol::kPhaseCount}, cell);
}

std::vector<double> ResultFile::ReadSamples(std::string_view dataset, const Cell& cell) const {
  return impl_->Reading([&] { return impl_->Block(dataset, cell, {0}); });
}

std::vector<double> ResultFile::ReadCycle(std::string_view dataset, const Cell& cell,
                                          std::uint64_t cycle) const {
  return impl_->Reading([&] {
    CDB_CHECK(cycle < impl_->CyclesOf(cell));
    hdf5::Dataset& array = impl_->Opened(dataset);
    const std::size_t n = impl_->grid.size();
    if (array.shape().size() != n + 3 || array.shape()[n] != impl_->cycles)
      throw hdf5::Error(fmt::format("{} is not a series of that kind", dataset));
    hdf5::Shape start = impl_->PlaceOf(cell);
    start.insert(start.end(), {cycle, 0, 0});
    hdf5::Shape count(n + 1, 1);
    count.insert(count.end(), array.shape().end() - 2, array.shape().end());
    return array.Read(start, count);
  });
}

std::vector<protocol::ContactRecord> ResultFile::ReadContacts(const Cell& cell, std::uint64_t first,
                                                              std::uint64_t count) const {
  if (count == 0) return {};
  return impl_->Reading([&] {
    const double begin = impl_->Number("contact_first", cell);
    if (!(begin >= 0)) throw hdf5::Error("contact_first has no row for a run with contacts");
    constexpr std::uint64_t kMostRows = std::uint64_t{1} << 53;
    if (!(begin < static_cast<double>(kMostRows)) || first > kMostRows)
      throw hdf5::Error("contact_first is beyond the rows of contacts");
    const auto row = static_cast<std::uint64_t>(begin) + first;
    const auto rows = [&](std::string_view dataset, std::uint64_t width) {
      hdf5::Dataset& array = impl_->Opened(dataset);
      hdf5::Shape start = {row}, extent = {count};
      if (width > 1) {
        start.push_back(0);
        extent.push_back(width);
      }
      if (array.shape().size() != start.size() || (width > 1 && array.shape()[1] != width))
        throw hdf5::Error(fmt::format("{} has another shape than contacts have", dataset));
      return array.Read(start, extent);
    };
    const std::vector<double> bodies = rows("contact_body", 2), points = rows("contact_point", 3),
                              normals = rows("contact_normal", 3),
                              distances = rows("contact_distance", 1);
    std::vector<protocol::ContactRecord> contacts(count);
    for (std::size_t i = 0; i < count; ++i) {
      contacts[i].body_a = bodies[2 * i];
      contacts[i].body_b = bodies[2 * i + 1];
      std::copy_n(&points[3 * i], 3, contacts[i].point);
      std::copy_n(&normals[3 * i], 3, contacts[i].normal);
      contacts[i].distance = distances[i];
    }
    return contacts;
  });
}

std::vector<ReferenceTrouble> ResultFile::ReadReferenceTroubles() const {
  return impl_->Reading([&] {
    std::vector<ReferenceTrouble> troubles;
    const hdf5::File& file = impl_->file;
    const std::string reference = impl_->PathOf(kReferenceGroup + "reference");
    if (!file.Has("accuracy/reference")) return troubles;
    const auto text = [&file](const std::string& name) {
      return file.OpenDataset(name).ReadText();
    };
    const std::vector<std::string> ids = text(reference), roles = text(kReferenceGroup + "role"),
                                   messages = text(kReferenceGroup + "message");
    const std::vector<double> statuses = file.OpenDataset(kReferenceGroup + "status").Read();
    if (roles.size() != ids.size() || messages.size() != ids.size() ||
        statuses.size() != ids.size())
      throw hdf5::Error("the arrays of its reference runs have several lengths");
    for (std::size_t i = 0; i < ids.size(); ++i) {
      CheckValues("status", std::span(&statuses[i], 1), impl_->extents());
      const auto status = static_cast<Status>(statuses[i]);
      // One that is done has a message only if it is not sound.
      const bool is_unsound = status == Status::kDone && !messages[i].empty();
      if (is_unsound)
        troubles.push_back({ids[i], messages[i], is_unsound});
      else if (status != Status::kDone && status != Status::kMissing)
        troubles.push_back({ids[i],
                            fmt::format("{} {}: {}{}{}", roles[i], ids[i], StatusName(status),
                                        messages[i].empty() ? "" : ": ", messages[i]),
                            is_unsound});
    }
    return troubles;
  });
}

std::string ResultFile::ReadProvenance(std::string_view name) const {
  return impl_->Reading([&]() -> std::string {
    const hdf5::Group group = impl_->file.OpenGroup("provenance");
    const std::string key(name);
    if (!group.Has(key)) return group.Text(key.c_str());
    const hdf5::Dataset dataset = group.OpenDataset(key);
    std::vector<std::string> texts = dataset.ReadText();
    std::erase(texts, "");
    std::ranges::sort(texts);
    const auto repeated = std::ranges::unique(texts);
    texts.erase(repeated.begin(), repeated.end());
    return fmt::format("{}", fmt::join(texts, "; "));
  });
}

std::string ResultFile::ReadProvenance(std::string_view name, const Cell& cell) const {
  return impl_->Reading([&]() -> std::string {
    const auto [found, is_new] = impl_->facts.try_emplace(std::string(name));
    Impl::Fact& fact = found->second;
    if (is_new) fact = impl_->ReadFact(found->first);
    if (fact.by_run.empty()) return fact.shared;
    const auto text = fact.by_run.find(ReadText("run_id", cell));
    return text == fact.by_run.end() ? std::string() : text->second;
  });
}

}  // namespace cdb::results
