#include "runtime/results/examine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
#include "runtime/protocol/series.h"
#include "runtime/results/files/limited_process.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/hdf5/object.h"
#include "runtime/results/layout.h"
#include "runtime/results/store.h"
#include "runtime/results/versions.h"

namespace cdb::results {
namespace {

/// Depth of a results file with references: its root, accuracy, accuracy/reference.
constexpr int kDeepestGroup = 3;
constexpr std::size_t kMostArrays = 10'000;
/// Limit of all measured numbers: 300 years in ns, 9 EB in bytes.
constexpr double kMostMeasured = 9.3e18;

std::uint64_t ExtentOf(protocol::Dimension dimension, const hdf5::File& file,
                       const FileExtents& extents) {
  const protocol::DimensionInfo& info = protocol::InfoOf(dimension);
  if (!info.labels.empty()) return info.labels.size();
  if (dimension == protocol::Dimension::kCycle) return extents.cycles;
  return hdf5::Product(file.OpenDataset(std::string(info.name)).shape());
}

void ExpectArray(const hdf5::File& file, const std::string& path, hdf5::Type type,
                 const hdf5::Shape& shape) {
  if (!file.Has(path)) return;
  const hdf5::Dataset dataset = file.OpenDataset(path);
  if (dataset.shape() != shape)
    throw hdf5::Error(fmt::format("{} has the shape [{}] where its axes have [{}]", path,
                                  fmt::join(dataset.shape(), " "), fmt::join(shape, " ")));
  if (dataset.type() != type)
    throw hdf5::Error(fmt::format("{} holds values of another type than it should", path));
}

[[noreturn]] void RefuseValue(std::string_view array, double value, std::string_view why) {
  throw hdf5::Error(fmt::format("{} holds {}, {}", array, value, why));
}

template <typename T>
void CheckSeriesValues(const protocol::Series& series, std::span<const T> values) {
  if (series.type == protocol::SeriesType::kInt32) {
    for (const T value : values)
      if (value < -1) RefuseValue(series.name, value, "which is no count");
  } else if (const bool is_duration = series.name == "duration";
             is_duration || series.name == "counters") {
    for (const T value : values)
      if (value < 0 || value > kMostMeasured)
        RefuseValue(series.name, value, is_duration ? "which is no duration" : "which is no count");
  }
}

void CheckNumberValues(const RunNumber& number, std::span<const double> values,
                       const FileExtents& extents) {
  // Counters of virtual machines have been observed to go backwards.
  double low = number.name == "run/steal" ? -kMostMeasured : 0, high = kMostMeasured;
  if (number.type == hdf5::Type::kInt32) low = -1;
  if (number.name == "n_cycles" || number.name == "first_bad_cycle")
    high = static_cast<double>(extents.cycles);
  if (number.flags != nullptr) {
    low = 0;
    high = static_cast<double>(std::ranges::count(number.flags(), ' '));
  }
  for (const double value : values)
    if (value < low || value > high)
      RefuseValue(number.name, value, fmt::format("and has values from {} to {}", low, high));
}

/// A run that is done has a time for each step, and the number of its pairs.
void CheckNoneMissing(const protocol::Series& series, std::span<const double> reals,
                      std::span<const std::int32_t> ints, std::uint64_t cycles) {
  const auto refuse = [&](auto at) {
    throw hdf5::Error(fmt::format("{} has no value in cycle {}", series.name, at));
  };
  if (series.name == "duration") {
    const auto step = reals.subspan(protocol::IndexOf(protocol::Phase::kStep) * cycles, cycles);
    const auto none = std::ranges::find_if(step, [](double value) { return std::isnan(value); });
    if (none != step.end()) refuse(none - step.begin());
  } else if (series.name == "pairs") {
    const auto none = std::ranges::find(ints, -1);
    if (none != ints.end()) refuse(none - ints.begin());
  }
}

void CheckContact(const protocol::ContactRecord& contact) {
  for (const double body : {contact.body_a, contact.body_b})
    if (!(body >= 0 && body <= std::numeric_limits<std::int32_t>::max()))
      RefuseValue("contact_body", body, "which is no body");
}

using VisitPiece = std::function<void(const std::string&, std::span<const double>)>;

void ReadArray(const std::string& path, const hdf5::Dataset& dataset, const VisitPiece& visit) {
  if (dataset.type() == hdf5::Type::kText) {
    dataset.ReadText();
    return;
  }
  if (dataset.ChunkShape().empty() || hdf5::Product(dataset.shape()) == 0)
    return visit(path, dataset.Read());
  dataset.ForEachStoredChunk([&](const hdf5::Shape& start, const hdf5::Shape& count) {
    visit(path, dataset.Read(start, count));
  });
}

void ReadGroup(const hdf5::Group& group, const std::string& prefix, int depth, std::size_t& arrays,
               const VisitPiece& visit) {
  if (depth > kDeepestGroup) throw hdf5::Error("its groups are nested too deeply");
  group.Texts();
  const hdf5::Group::Names names = group.List();
  arrays += names.datasets.size();
  if (arrays > kMostArrays) throw hdf5::Error("it has more arrays than a results file");
  for (const std::string& name : names.datasets) {
    const hdf5::Dataset dataset = group.OpenDataset(name);
    try {
      ReadArray(prefix + name, dataset, visit);
    } catch (const hdf5::Error& error) {
      const std::string_view why = error.what();
      const bool is_named = why.starts_with(prefix + name);
      throw hdf5::Error(is_named ? std::string(why) : fmt::format("{}{}: {}", prefix, name, why));
    }
  }
  for (const std::string& name : names.groups)
    ReadGroup(group.OpenGroup(name), prefix + name + "/", depth + 1, arrays, visit);
}

}  // namespace

void CheckArrays(const hdf5::File& file, const FileExtents& extents) {
  for (const protocol::Series& series : protocol::AllSeries()) {
    const std::string name(series.name);
    if (!file.Has(name)) continue;
    hdf5::Shape shape = extents.grid;
    for (const protocol::Dimension dimension : protocol::DimensionsOf(series.shape))
      shape.push_back(ExtentOf(dimension, file, extents));
    const bool is_int = series.type == protocol::SeriesType::kInt32;
    ExpectArray(file, name, is_int ? hdf5::Type::kInt32 : hdf5::Type::kFloat64, shape);
  }
  for (const RunNumber& number : RunNumbers())
    ExpectArray(file, PathIn(extents.version, number.name), number.type, extents.grid);
  for (const RunText& text : RunTexts())
    ExpectArray(file, PathIn(extents.version, text.name), hdf5::Type::kText, extents.grid);
}

void CheckValues(std::string_view array, std::span<const double> values,
                 const FileExtents& extents) {
  if (const protocol::Series* series = protocol::FindSeries(array))
    return CheckSeriesValues(*series, values);
  const auto number = std::ranges::find(RunNumbers(), array, &RunNumber::name);
  if (number != RunNumbers().end()) CheckNumberValues(*number, values, extents);
}

std::string FindFault(const RunResult& result, std::uint64_t cycles) {
  try {
    for (const auto& [series, bytes] : result.series) {
      const bool is_int = series->type == protocol::SeriesType::kInt32;
      const std::span reals(reinterpret_cast<const double*>(bytes.data()),
                            is_int ? 0 : bytes.size() / sizeof(double));
      const std::span ints(reinterpret_cast<const std::int32_t*>(bytes.data()),
                           is_int ? bytes.size() / sizeof(std::int32_t) : 0);
      CheckSeriesValues(*series, reals);
      CheckSeriesValues(*series, ints);
      if (result.status == Status::kDone) CheckNoneMissing(*series, reals, ints, cycles);
    }
    for (const RunNumber& number : RunNumbers())
      CheckNumberValues(number, std::array{number.get(result)}, {0, {}, cycles});
    std::ranges::for_each(result.contacts, CheckContact);
  } catch (const hdf5::Error& error) {
    return error.what();
  }
  return {};
}

void ReadEverything(const hdf5::File& file, const VisitPiece& visit) {
  std::size_t arrays = 0;
  ReadGroup(file, "", 1, arrays, visit);
}

void CheckAllValues(const hdf5::File& file, const FileExtents& extents) {
  std::map<std::string, std::string> names;
  for (const RunNumber& number : RunNumbers())
    names.emplace(PathIn(extents.version, number.name), number.name);
  ReadEverything(file, [&](const std::string& path, std::span<const double> values) {
    const auto found = names.find(path);
    CheckValues(found == names.end() ? path : found->second, values, extents);
  });
}

namespace {

/// Nullopt for a plan in the short form, which only a compiler can read, and for one that this
/// version does not read.
std::optional<plan::Plan> ReadListedPlan(const std::string& text) {
  try {
    if (yaml::FindShortPlan(text, "plan_text")) return std::nullopt;
    return yaml::FromYaml(text, "plan_text");
  } catch (const yaml::PlanError&) {
    return std::nullopt;
  }
}

void CheckCoordinates(const hdf5::File& file, const plan::Axis& axis) {
  const hdf5::Dataset dataset = file.OpenDataset(axis.name);
  std::vector<plan::Coordinate> values;
  if (dataset.type() == hdf5::Type::kText) {
    for (std::string& text : dataset.ReadText()) values.emplace_back(std::move(text));
  } else {
    for (const double value : dataset.Read()) values.emplace_back(value);
  }
  if (values != axis.values)
    throw hdf5::Error(fmt::format("the axis {} has other values than its plan", axis.name));
}

/// Earlier versions had fewer arrays.
void CheckIsAs(const hdf5::File& file, const std::string& name, hdf5::Type type,
               const hdf5::Shape& shape) {
  if (!file.Has(name)) return;
  const hdf5::Dataset dataset = file.OpenDataset(name);
  if (dataset.type() != type || dataset.shape() != shape)
    throw hdf5::Error(fmt::format("{} has another type or shape than its plan has", name));
}

std::uint64_t RowsOfContacts(const hdf5::File& file) {
  return file.Has("contact_row") ? hdf5::Product(file.OpenDataset("contact_row").shape()) : 0;
}

void CheckLayout(const hdf5::File& file, const FileExtents& extents, const plan::Plan& plan) {
  const PlanFacts facts(plan);
  const Layout layout = MakeLayout(plan, facts, RowsOfContacts(file));
  if (layout.grid != extents.grid || facts.cycles != extents.cycles)
    throw hdf5::Error("its axes are not as long as its plan has them");
  for (const Dimension& dimension : layout.dimensions)
    CheckIsAs(file, dimension.name, dimension.type, {dimension.size});
  for (const Array& array : layout.arrays) CheckIsAs(file, array.name, array.type, array.shape);
  const bool has_durations =
      std::ranges::find(layout.arrays, "duration", &Array::name) != layout.arrays.end();
  if (has_durations && !file.Has("duration"))
    throw hdf5::Error("it lacks the durations that its plan records");
}

void CheckRuns(const hdf5::File& file, const FileExtents& extents, const plan::Plan& plan) {
  const std::vector<double> statuses = file.OpenDataset("status").Read();
  const std::vector<std::string> ids =
      file.OpenDataset(PathIn(extents.version, "run/run_id")).ReadText();
  plan.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
    std::size_t cell = 0;
    for (std::size_t i = 0; i < at.size(); ++i) cell = cell * extents.grid[i] + at[i];
    cell = cell * extents.grid.back() + rep;
    // A search or a race leaves out the runs that it does not need.
    if (!plan.ChoosesRuns() && statuses.at(cell) == static_cast<double>(Status::kSkipped))
      throw hdf5::Error(fmt::format("the run {} of its plan is marked as skipped", id));
    if (ids.at(cell) != id)
      throw hdf5::Error(fmt::format("it contains the run {} where its plan has {}", ids[cell], id));
  });
}

}  // namespace

void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents, const plan::Plan& plan) {
  if (plan.Sha256() != file.Text("plan_sha256"))
    throw hdf5::Error("its plan differs from its plan_sha256");
  if (extents.grid.size() != plan.axes.size() + 1 || extents.grid.back() != plan.repeats)
    throw hdf5::Error("its axes differ from those of its plan");
  if (extents.version == kSchemaVersion) CheckLayout(file, extents, plan);
  for (const plan::Axis& axis : plan.axes) CheckCoordinates(file, axis);
  CheckRuns(file, extents, plan);
}

void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents,
                      const std::string& plan_text) {
  // Earlier versions, which wrote no digest, had files without a plan.
  if (plan_text.empty() && !file.Text(kDigestAttribute).empty())
    throw hdf5::Error("it contains no plan");
  if (extents.version != kSchemaVersion) return;
  if (const auto plan = ReadListedPlan(plan_text)) CheckAgainstPlan(file, extents, *plan);
}

namespace {

namespace fs = std::filesystem;

}  // namespace

files::WorkLimits LimitsForEveryValue(std::uint64_t bytes) {
  // The file may be mostly its plan: yaml-cpp takes 42 bytes for one of the text, and the plan has
  // as many again.
  constexpr std::uint64_t kPlanMemory = 80;
  files::WorkLimits limits = files::LimitsForFile(bytes);
  limits.memory_bytes += kPlanMemory * bytes;
  return limits;
}

bool ProveFile(const fs::path& path, std::string_view remedy, ProofOf of,
               const std::function<void(bool reads_values)>& read) {
  const files::SealState seal = files::CheckSeal(path);
  if (seal == files::SealState::kBroken)
    throw files::StoreError(
        fmt::format("{}: is damaged: its digest differs, so that some of its bytes are not as they "
                    "were written; it was left as it is: {}",
                    path.string(), remedy));
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  const bool reads_values =
      of == ProofOf::kEveryValue || (of == ProofOf::kFewValues && bytes <= kMostProven);
  const auto prove = [&] {
    if (reads_values) hdf5::CheckGlobalHeaps(path);
    read(reads_values);
  };
  const auto limits_for = of == ProofOf::kEveryValue ? LimitsForEveryValue : files::LimitsForFile;
  const std::string why = files::RunLimited(prove, limits_for(error ? 0 : bytes));
  if (why.empty()) return seal == files::SealState::kGood;
  if (why.starts_with(path.string() + ": ")) throw files::StoreError(why);
  throw files::StoreError(
      fmt::format("{}: is not a whole result of cdb: {}; it was left as it is: {}", path.string(),
                  why, remedy));
}

void RequireSeal(const hdf5::File& file, const fs::path& path) {
  if (!file.Text(kDigestAttribute).empty() && !files::IsSealed(path))
    throw hdf5::Error("its digest is missing, as its end was cut off or changed");
}

bool IsStored(const fs::path& path) { return hdf5::IsHdf5(path) || files::IsSealed(path); }

std::string ReadSchema(const fs::path& path) {
  if (std::error_code error; !fs::exists(path, error))
    throw files::StoreError(
        fmt::format("{}: there is no such file; `cdb run` makes one", path.string()));
  if (!hdf5::IsHdf5(path))
    throw files::StoreError(
        fmt::format("{}: is damaged: it ends as a file of cdb does, but does not begin as HDF5; it "
                    "was left as it is: restore a copy, or run it again",
                    path.string()));
  const auto read = [&] { return hdf5::File::Open(path).Text("schema"); };
  const std::string why = files::RunLimited([&] { read(); }, files::LimitsForFile(0));
  if (!why.empty())
    throw files::StoreError(
        fmt::format("{}: is damaged: {}; it was left as it is: restore a copy, or run "
                    "it again",
                    path.string(), why));
  return read();
}

}  // namespace cdb::results
