#include "runtime/results/trace_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <system_error>
#include <vector>

#include "runtime/protocol/series.h"
#include "runtime/results/examine.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"
#include "runtime/results/versions.h"

namespace cdb::results {
namespace {

namespace fs = std::filesystem;
using hdf5::Type;

hdf5::Shape ChunkOf(const hdf5::Shape& shape, std::size_t item_bytes) {
  hdf5::Shape chunk = shape;
  for (std::size_t i = 0; i + 1 < chunk.size(); ++i) hdf5::SplitEvenly(chunk, i, item_bytes);
  return chunk;
}

void AddScale(hdf5::File& file, const Dimension& dimension) {
  hdf5::Dataset scale =
      file.CreateDataset({dimension.name, dimension.type, {dimension.size}, {}, 0});
  if (dimension.type == Type::kText) {
    scale.WriteText(dimension.texts);
  } else {
    scale.Write(dimension.numbers);
  }
  scale.MakeScale(dimension.name);
  for (const auto& [name, text] : dimension.attributes) scale.SetText(name.c_str(), text);
}

void AddScale(hdf5::File& file, protocol::Dimension dimension) {
  const protocol::DimensionInfo& info = protocol::InfoOf(dimension);
  AddScale(file, Labelled(std::string(info.name), {info.labels.begin(), info.labels.end()},
                          std::string(info.doc)));
}

void AddText(hdf5::File& file, const char* name, const std::string& text, const char* doc) {
  hdf5::Dataset dataset = file.CreateDataset({name, Type::kText, {}, {}, 0});
  dataset.WriteText({{text}});
  dataset.SetText("long_name", doc);
}

void WriteHead(hdf5::File& file, const protocol::TraceMemory& trace, const TraceOrigin& origin,
               std::uint64_t objects) {
  const protocol::TraceShape& shape = trace.shape();
  const auto number = [&](const char* name, std::uint64_t value) {
    file.SetNumber(name, Type::kInt32, static_cast<double>(value));
  };
  file.SetText("Conventions", kConventions);
  file.SetText("title", origin.point.empty()
                            ? origin.benchmark
                            : fmt::format("{}: {}", origin.benchmark, origin.point));
  file.SetText("schema", kTraceSchema);
  number("schema_version", kTraceSchemaVersion);
  file.SetText("date_created",
               fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))));
  file.SetText("benchmark", origin.benchmark);
  file.SetText("point", origin.point);
  file.SetText("run_id", origin.run_id);
  file.SetText("state_hash", origin.state_hash);
  file.SetText("sha256", trace.Sha256());
  file.SetText("precision", shape.is_double ? "double" : "single");
  file.SetNumber("timestep", Type::kFloat64, origin.timestep_s);
  number("bodies", shape.bodies);
  number("objects", objects);
  number("cycles", shape.cycles);
}

void WriteArrays(hdf5::File& file, const protocol::TraceMemory& trace, std::uint64_t objects,
                 std::span<const double> poses) {
  const protocol::TraceShape& shape = trace.shape();
  const Type real = shape.is_double ? Type::kFloat64 : Type::kFloat32;
  AddScale(file, Counted("cycle", shape.cycles, "cycle of the run"));
  AddScale(file, Counted("body", shape.bodies, "objects, then walls"));
  AddScale(file, Counted("object", objects, "object, in the order of its group and within it"));
  for (const protocol::Dimension dimension :
       {protocol::Dimension::kBound, protocol::Dimension::kFilter, protocol::Dimension::kPose})
    AddScale(file, dimension);

  const hdf5::Shape all = {shape.cycles, shape.bodies, protocol::kBoxSize};
  hdf5::Dataset boxes =
      file.CreateDataset({"boxes", real, all, ChunkOf(all, shape.ItemBytes()), NAN});
  boxes.SetText("units", "m");
  boxes.SetText("long_name", "boxes as the broad phase was given them; objects, then walls");
  for (std::uint64_t cycle = 0; cycle < shape.cycles; ++cycle)
    boxes.Write({cycle, 0, 0}, {1, shape.bodies, protocol::kBoxSize}, trace.BoxBytes(cycle).data(),
                {1, shape.bodies, protocol::kBoxSize});

  hdf5::Dataset filters = file.CreateDataset(
      {"filters", Type::kFloat64, {shape.bodies, protocol::kFilterSize}, {}, NAN});
  filters.SetText("units", kNoUnit);
  filters.SetText("long_name", "two may meet where each one's group is in the other's mask");
  std::vector<double> numbers;
  for (const protocol::TraceFilter& filter : trace.filters())
    numbers.insert(numbers.end(),
                   {static_cast<double>(filter.group), static_cast<double>(filter.mask),
                    static_cast<double>(filter.is_fixed)});
  filters.Write(numbers);

  std::vector<hdf5::Group::Attachment> attachments = {{"boxes", {"cycle", "body", "bound"}},
                                                      {"filters", {"body", "filter"}}};
  if (objects > 0) {
    const hdf5::Shape placed = {shape.cycles, objects, protocol::kPoseSize};
    hdf5::Dataset dataset =
        file.CreateDataset({"poses", real, placed, ChunkOf(placed, shape.ItemBytes()), NAN});
    dataset.SetText("component_units", protocol::InfoOf(protocol::Dimension::kPose).units);
    dataset.SetText("long_name",
                    "centre of mass and orientation quaternion after the cycle; objects");
    const std::size_t per_cycle = objects * protocol::kPoseSize;
    for (std::uint64_t cycle = 0; cycle < shape.cycles; ++cycle)
      dataset.Write({cycle, 0, 0}, {1, objects, protocol::kPoseSize},
                    poses.subspan(cycle * per_cycle, per_cycle));
    attachments.push_back({"poses", {"cycle", "object", "pose"}});
  }
  file.AttachScales(attachments);
}

/// The error for a file that cannot be used: its name, then the reason.
files::StoreError Useless(const fs::path& file, std::string_view why) {
  return files::StoreError(fmt::format("{}: {}; `cdb trace` makes it anew", file.string(), why));
}

hdf5::File OpenTrace(const fs::path& path) {
  try {
    hdf5::File file = hdf5::File::Open(path);
    RequireSeal(file, path);
    const std::string schema = file.Text("schema");
    if (schema != kTraceSchema)
      throw files::StoreError(fmt::format("{}: it is HDF5, but no trace{}", path.string(),
                                          schema.empty() ? "" : fmt::format(" ({})", schema)));
    if (const double version = file.Number("schema_version"); version != kTraceSchemaVersion)
      throw Useless(path, fmt::format("it is a trace of version {}, and this cdb reads version {}",
                                      version, kTraceSchemaVersion));
    return file;
  } catch (const hdf5::Error& why) {
    throw files::StoreError(
        fmt::format("{}: it is no trace, or damaged: {}", path.string(), why.what()));
  }
}

/// The result of `read`, with the file's name added to errors of HDF5 and of the system.
template <typename Read>
auto Undamaged(const fs::path& path, Read read) {
  try {
    return read();
  } catch (const hdf5::Error& why) {
    throw Useless(path, fmt::format("it is damaged: {}", why.what()));
  } catch (const std::system_error& why) {
    throw files::StoreError(fmt::format("{}: {}", path.string(), why.what()));
  }
}

analysis::TraceFacts FactsOf(const hdf5::File& file, const fs::path& path) {
  const auto count = [&](const char* name) {
    const double value = file.Number(name);
    if (!(value >= 1 && value <= std::numeric_limits<std::int32_t>::max()) ||
        value != std::floor(value))
      throw Useless(path, fmt::format("its head says nothing of {}", name));
    return static_cast<std::uint64_t>(value);
  };
  analysis::TraceFacts facts;
  facts.sha256 = file.Text("sha256");
  facts.bodies = count("bodies");
  facts.cycles = count("cycles");
  facts.timestep_s = file.Number("timestep");
  facts.is_double = file.Text("precision") == "double";
  if (facts.sha256.size() != 64 || !(facts.timestep_s > 0))
    throw Useless(path, "its head is not whole");
  return facts;
}

/// Checks that its arrays and coordinates match its head.
void CheckHead(const hdf5::File& file, const analysis::TraceFacts& facts, const fs::path& path) {
  const auto expect = [&](const char* name, const hdf5::Shape& shape) {
    if (file.OpenDataset(name).shape() != shape)
      throw Useless(path, fmt::format("its '{}' is not as its head says", name));
  };
  const hdf5::Shape boxes = {facts.cycles, facts.bodies, protocol::kBoxSize};
  expect("cycle", {facts.cycles});
  expect("body", {facts.bodies});
  expect("boxes", boxes);
  expect("filters", {facts.bodies, protocol::kFilterSize});
  const double objects = file.Number("objects");
  if (!(objects >= 0 && objects <= static_cast<double>(facts.bodies)))
    throw Useless(path, "its head has more objects than bodies");
  const auto count = static_cast<std::uint64_t>(objects);
  expect("object", {count});
  if (count > 0) expect("poses", {facts.cycles, count, protocol::kPoseSize});
  file.OpenDataset("boxes").CheckCount(hdf5::Product(boxes));
}

protocol::TraceMemory ReadMemory(const hdf5::File& file, const analysis::TraceFacts& facts,
                                 const fs::path& path) {
  const hdf5::Dataset boxes = file.OpenDataset("boxes");
  CheckHead(file, facts, path);
  const std::vector<double> filters = file.OpenDataset("filters").Read();
  protocol::TraceMemory trace =
      protocol::TraceMemory::Create({facts.bodies, facts.cycles, facts.is_double});
  constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
  if (!std::ranges::all_of(filters, [](double bits) { return bits >= 0 && bits <= kMost; }))
    throw Useless(path, "its filters are not what a trace has");
  for (std::size_t i = 0; i < facts.bodies; ++i)
    trace.filters()[i] = {static_cast<std::uint32_t>(filters[i * protocol::kFilterSize]),
                          static_cast<std::uint32_t>(filters[i * protocol::kFilterSize + 1]),
                          static_cast<std::uint32_t>(filters[i * protocol::kFilterSize + 2])};
  for (std::uint64_t cycle = 0; cycle < facts.cycles; ++cycle)
    trace.SetBoxes(cycle, boxes.Read({cycle, 0, 0}, {1, facts.bodies, protocol::kBoxSize}));
  return trace;
}

constexpr std::string_view kTraceRemedy = "`cdb trace` makes it anew";

/// Throws StoreError if it is not as it was written, or crashes HDF5. True if it has a seal.
bool ProveTrace(const fs::path& path, ProofOf of) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    throw files::StoreError(
        fmt::format("{}: {}", path.string(),
                    fs::exists(path, error) ? "it is no file" : "there is no such file"));
  return ProveFile(path, kTraceRemedy, of, [&](bool reads_values) {
    const hdf5::File file = OpenTrace(path);
    Undamaged(path, [&] {
      CheckHead(file, FactsOf(file, path), path);
      if (reads_values) ReadEverything(file, [](const std::string&, std::span<const double>) {});
    });
  });
}

hdf5::File OpenProvenTrace(const fs::path& path, ProofOf of) {
  ProveTrace(path, of);
  return OpenTrace(path);
}

}  // namespace

void WriteTrace(const protocol::TraceMemory& trace, const TraceOrigin& origin,
                std::uint64_t objects, std::span<const double> poses, const fs::path& path) {
  files::RemoveStaleTemporariesBeside(path);
  files::TemporaryFile temporary(path);
  try {
    hdf5::File file = hdf5::File::Create(temporary.path());
    WriteHead(file, trace, origin, objects);
    WriteArrays(file, trace, objects, poses);
    AddText(file, "scenario_text", origin.scenario_text, "the scenario that was recorded");
    AddText(file, "run_text", origin.run_text, "all that decides the run, as YAML");
    file.SetText(kDigestAttribute, kDigestText);
    file.Close();
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: cannot be written: {}; make room, or name another place (-o)",
                    path.string(), error.what()));
  }
  files::AppendSeal(temporary.path(), path);
  temporary.Publish();
}

analysis::TraceFacts ReadTraceFacts(const fs::path& path) {
  const hdf5::File file = OpenProvenTrace(path, ProofOf::kStructure);
  return Undamaged(path, [&] { return FactsOf(file, path); });
}

std::optional<std::string> TracedRun(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return std::nullopt;
  try {
    const hdf5::File file = OpenProvenTrace(path, ProofOf::kStructure);
    return Undamaged(path, [&] { return file.Text("run_id"); });
  } catch (const files::StoreError&) {
    return std::nullopt;
  }
}

TraceCheck CheckTrace(const fs::path& path) {
  TraceCheck check;
  check.has_digest = ProveTrace(path, ProofOf::kEveryValue);
  const hdf5::File file = OpenTrace(path);
  check.facts = Undamaged(path, [&] { return FactsOf(file, path); });
  check.run_id = file.Text("run_id");
  if (ReadMemory(file, check.facts, path).Sha256() != check.facts.sha256)
    throw Useless(path, "it is damaged");
  return check;
}

protocol::TraceMemory LoadTrace(const fs::path& path, const std::string& sha256) {
  const hdf5::File file = OpenProvenTrace(path, ProofOf::kFewValues);
  const analysis::TraceFacts facts = Undamaged(path, [&] { return FactsOf(file, path); });
  if (facts.sha256 != sha256)
    throw files::StoreError(
        fmt::format("{}: it holds the trace {} and this plan is of {}; plan again, or "
                    "put the other back",
                    path.string(), facts.sha256.substr(0, 16), sha256.substr(0, 16)));
  protocol::TraceMemory trace = Undamaged(path, [&] { return ReadMemory(file, facts, path); });
  if (trace.Sha256() != sha256) throw Useless(path, "it is damaged");
  return trace;
}

}  // namespace cdb::results
