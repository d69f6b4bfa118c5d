#include "runtime/results/trace_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iterator>
#include <limits>
#include <optional>
#include <system_error>
#include <tuple>
#include <utility>
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

/// Of a list: whole rows.
hdf5::Shape ChunkOfRows(const hdf5::Shape& shape) {
  hdf5::Shape chunk = shape;
  hdf5::SplitEvenly(chunk, 0, sizeof(std::int32_t));
  return chunk;
}

void AddScale(hdf5::File& file, const Dimension& dimension) {
  hdf5::Dataset scale =
      file.CreateDataset({dimension.name, dimension.type, {dimension.size}, {}, 0});
  if (dimension.type == Type::kText) {
    scale.WriteText(dimension.texts);
  } else if (!dimension.numbers.empty() || dimension.size == 0) {
    scale.Write(dimension.numbers);
  } else {
    return scale.MakeScale(fmt::format("{}{:10}", kNoCoordinate, dimension.size));
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

constexpr const char* kFrameParts[] = {"x",   "y",   "z",   "x_x", "x_y", "x_z",
                                       "y_x", "y_y", "y_z", "z_x", "z_y", "z_z"};
static_assert(std::size(kFrameParts) == protocol::kFrameSize);

constexpr std::uint64_t kCorners = std::tuple_size_v<deforming::Corners>;

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
  if (shape.primitives) {
    file.SetText("primitives", deforming::WordOf(*shape.primitives));
    number("vertices", shape.vertices);
  }
  if (!shape.HasPairs()) return;
  file.SetText("pairs_sha256", trace.PairsSha256());
  file.SetNumber("pairs", Type::kFloat64, static_cast<double>(shape.pairs));
  number("walls", trace.walls());
}

/// The input of the narrow phase. Returns the scales of its arrays.
std::vector<hdf5::Group::Attachment> WritePairs(hdf5::File& file,
                                                const protocol::TraceMemory& trace) {
  const protocol::TraceShape& shape = trace.shape();
  AddScale(file, Labelled("frame", {std::begin(kFrameParts), std::end(kFrameParts)},
                          "centre of mass, and the axes of the body in the world"));
  AddScale(file, Counted("pair_side", 2, "the two bodies of a pair"));
  const hdf5::Shape all = {shape.cycles, shape.bodies, protocol::kFrameSize};
  hdf5::Dataset frames =
      file.CreateDataset({"frames", shape.is_double ? Type::kFloat64 : Type::kFloat32, all,
                          ChunkOf(all, shape.ItemBytes()), NAN});
  frames.SetText("component_units", "m m m 1 1 1 1 1 1 1 1 1");
  frames.SetText("long_name", "pose of each body as the narrow phase was given it");
  for (std::uint64_t cycle = 0; cycle < shape.cycles; ++cycle)
    frames.Write({cycle, 0, 0}, {1, shape.bodies, protocol::kFrameSize},
                 trace.FrameBytes(cycle).data(), {1, shape.bodies, protocol::kFrameSize});
  hdf5::Dataset first = file.CreateDataset({"first_pair", Type::kFloat64, {shape.cycles}, {}, NAN});
  first.SetText("units", kNoUnit);
  first.SetText("long_name", "row of the cycle's first pair in pair_bodies");
  const auto starts = trace.first_pairs().first(shape.cycles);
  first.Write(std::vector<double>(starts.begin(), starts.end()));
  std::vector<hdf5::Group::Attachment> attachments = {{"frames", {"cycle", "body", "frame"}},
                                                      {"first_pair", {"cycle"}}};
  if (shape.pairs > 0) {
    Dimension pair;
    pair.name = "pair";
    pair.size = shape.pairs;
    AddScale(file, pair);
    const hdf5::Shape rows = {shape.pairs, 2};
    hdf5::Dataset bodies =
        file.CreateDataset({"pair_bodies", Type::kInt32, rows, ChunkOfRows(rows), -1});
    bodies.SetText("units", kNoUnit);
    bodies.SetText("long_name",
                   "pairs that the narrow phase was given, in the order of their bodies");
    static_assert(sizeof(protocol::TracePair) == 2 * sizeof(std::int32_t));
    bodies.Write({0, 0}, rows, std::as_bytes(trace.pairs()).data(), rows);
    attachments.push_back({"pair_bodies", {"pair", "pair_side"}});
  }
  return attachments;
}

/// The vertices of a deforming mesh, and of its bodies. Returns the scales of its arrays.
std::vector<hdf5::Group::Attachment> WriteMesh(hdf5::File& file,
                                               const protocol::TraceMemory& trace) {
  const protocol::TraceShape& shape = trace.shape();
  AddScale(file, Counted("corner", kCorners, "vertex of a body"));
  AddScale(file, Counted("mesh_frame", shape.MeshFrames(), "frame of the mesh"));
  AddScale(file, Counted("vertex", shape.vertices, "vertex, in the order of the mesh"));
  AddScale(file, Labelled("axis", {"x", "y", "z"}, "axis of the world"));

  const hdf5::Shape rows = {shape.bodies, kCorners};
  hdf5::Dataset corners =
      file.CreateDataset({"corners", Type::kInt32, rows, ChunkOfRows(rows), -1});
  corners.SetText("units", kNoUnit);
  corners.SetText("long_name", "vertices of each body; -1 where an edge or a vertex has none");
  static_assert(sizeof(deforming::Corners) == kCorners * sizeof(std::int32_t) &&
                static_cast<std::int32_t>(deforming::kNoCorner) == -1);
  corners.Write({0, 0}, rows, std::as_bytes(trace.corners()).data(), rows);

  const hdf5::Shape all = {shape.MeshFrames(), shape.vertices, 3};
  hdf5::Dataset vertices =
      file.CreateDataset({"vertices", shape.is_double ? Type::kFloat64 : Type::kFloat32, all,
                          ChunkOf(all, shape.ItemBytes()), NAN});
  vertices.SetText("units", "m");
  vertices.SetText("long_name", "positions of the vertices of the mesh");
  const hdf5::Shape one = {1, shape.vertices, 3};
  for (std::uint64_t frame = 0; frame < shape.MeshFrames(); ++frame)
    vertices.Write({frame, 0, 0}, one, trace.VertexBytes(frame).data(), one);
  return {{"corners", {"body", "corner"}}, {"vertices", {"mesh_frame", "vertex", "axis"}}};
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
  if (trace.shape().HasPairs())
    for (auto& attachment : WritePairs(file, trace)) attachments.push_back(std::move(attachment));
  if (shape.primitives)
    for (auto& attachment : WriteMesh(file, trace)) attachments.push_back(std::move(attachment));
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
  if (const std::string word = file.Text("primitives"); !word.empty()) {
    const auto primitives = deforming::PrimitivesOf(word);
    if (!primitives)
      throw Useless(path, fmt::format("its primitives '{}' are none of {}", word,
                                      deforming::PrimitiveWords()));
    facts.primitives = word;
    facts.vertices = count("vertices");
  }
  facts.pairs_sha256 = file.Text("pairs_sha256");
  if (!facts.primitives.empty() && !facts.pairs_sha256.empty())
    throw Useless(path, "a deforming mesh has no poses");
  if (facts.pairs_sha256.empty()) return facts;
  const double pairs = file.Number("pairs"), walls = file.Number("walls");
  constexpr double kMost = 1e15, kAllWalls = 63;
  if (facts.pairs_sha256.size() != 64 || !(pairs >= 0 && pairs <= kMost) ||
      pairs != std::floor(pairs) || !(walls >= 0 && walls <= kAllWalls))
    throw Useless(path, "its head is not whole");
  facts.pairs = static_cast<std::uint64_t>(pairs);
  return facts;
}

/// Without pairs.
protocol::TraceShape ShapeOf(const analysis::TraceFacts& facts) {
  protocol::TraceShape shape = {facts.bodies, facts.cycles, facts.is_double};
  shape.primitives = deforming::PrimitivesOf(facts.primitives);
  shape.vertices = facts.vertices;
  return shape;
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
  if (!facts.primitives.empty()) {
    const protocol::TraceShape shape = ShapeOf(facts);
    const hdf5::Shape vertices = {shape.MeshFrames(), shape.vertices, 3};
    expect("corners", {facts.bodies, kCorners});
    expect("vertices", vertices);
    file.OpenDataset("corners").CheckCount(facts.bodies * kCorners);
    file.OpenDataset("vertices").CheckCount(hdf5::Product(vertices));
  }
  if (facts.pairs_sha256.empty()) return;
  const hdf5::Shape frames = {facts.cycles, facts.bodies, protocol::kFrameSize};
  expect("frames", frames);
  expect("first_pair", {facts.cycles});
  if (facts.pairs > 0) {
    expect("pair_bodies", {facts.pairs, 2});
    file.OpenDataset("pair_bodies").CheckCount(2 * facts.pairs);
  }
  file.OpenDataset("frames").CheckCount(hdf5::Product(frames));
}

/// The poses of a cycle.
std::vector<double> ReadFrames(const hdf5::Dataset& dataset, const protocol::TraceShape& shape,
                               std::uint64_t cycle, const fs::path& path) {
  constexpr double kUnit = 1e-3;  // an axis is as long, but for rounding
  std::vector<double> frames = dataset.Read({cycle, 0, 0}, {1, shape.bodies, protocol::kFrameSize});
  for (std::size_t at = 0; at < frames.size(); at += protocol::kFrameSize) {
    const double* frame = &frames[at];
    bool is_pose = std::all_of(frame, frame + protocol::kFrameSize,
                               [](double part) { return std::isfinite(part); });
    for (std::size_t axis = 3; axis < protocol::kFrameSize; axis += 3)
      is_pose = is_pose &&
                std::fabs(std::hypot(frame[axis], frame[axis + 1], frame[axis + 2]) - 1) <= kUnit;
    if (!is_pose)
      throw Useless(
          path, fmt::format("body {} has no pose in cycle {}", at / protocol::kFrameSize, cycle));
  }
  return frames;
}

/// The pairs of a cycle, `first` to `end` in the list of all.
std::vector<protocol::TracePair> ReadPairs(const std::optional<hdf5::Dataset>& dataset,
                                           std::uint64_t bodies, std::uint64_t first,
                                           std::uint64_t end, const fs::path& path) {
  std::vector<protocol::TracePair> pairs;
  if (first == end) return pairs;
  const std::vector<double> rows = dataset->Read({first, 0}, {end - first, 2});
  for (std::size_t i = 0; i < rows.size(); i += 2) {
    if (!(rows[i] >= 0 && rows[i] < rows[i + 1] && rows[i + 1] < static_cast<double>(bodies)))
      throw Useless(path, fmt::format("its pair {} is not two of its bodies", first + i / 2));
    pairs.push_back({static_cast<std::uint32_t>(rows[i]), static_cast<std::uint32_t>(rows[i + 1])});
    if (i > 0 && !(pairs[i / 2 - 1] < pairs[i / 2]))
      throw Useless(path, fmt::format("its pair {} is not after the one before", first + i / 2));
  }
  return pairs;
}

void FillPairs(const hdf5::File& file, const fs::path& path, const std::string& run_text,
               protocol::TraceMemory& trace) {
  const protocol::TraceShape& shape = trace.shape();
  trace.SetRun(static_cast<std::uint64_t>(file.Number("walls")), run_text);
  std::vector<double> first = file.OpenDataset("first_pair").Read();
  first.push_back(static_cast<double>(shape.pairs));
  if (first[0] != 0 || !std::ranges::all_of(first, [](double row) { return row >= 0; }) ||
      !std::ranges::is_sorted(first) ||
      !std::ranges::all_of(first, [](double row) { return row == std::floor(row); }))
    throw Useless(path, "its 'first_pair' are not the rows of its cycles");
  std::optional<hdf5::Dataset> bodies;
  if (shape.pairs > 0) bodies.emplace(file.OpenDataset("pair_bodies"));
  const hdf5::Dataset frames = file.OpenDataset("frames");
  for (std::uint64_t cycle = 0; cycle < shape.cycles; ++cycle)
    trace.SetPairs(cycle, ReadFrames(frames, shape, cycle, path),
                   ReadPairs(bodies, shape.bodies, static_cast<std::uint64_t>(first[cycle]),
                             static_cast<std::uint64_t>(first[cycle + 1]), path));
}

void FillMesh(const hdf5::File& file, const fs::path& path, protocol::TraceMemory& trace) {
  const protocol::TraceShape& shape = trace.shape();
  const std::vector<double> corners = file.OpenDataset("corners").Read();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const bool is_vertex = corners[i] >= 0 && corners[i] < static_cast<double>(shape.vertices);
    if (!is_vertex && (corners[i] != -1 || i % kCorners == 0))
      throw Useless(path, fmt::format("a corner of body {} is no vertex", i / kCorners));
    trace.corners()[i / kCorners][i % kCorners] =
        is_vertex ? static_cast<std::uint32_t>(corners[i]) : deforming::kNoCorner;
  }
  const hdf5::Dataset vertices = file.OpenDataset("vertices");
  for (std::uint64_t frame = 0; frame < shape.MeshFrames(); ++frame)
    trace.SetVertices(frame, vertices.Read({frame, 0, 0}, {1, shape.vertices, 3}));
}

protocol::TraceMemory ReadMemory(const hdf5::File& file, const analysis::TraceFacts& facts,
                                 bool with_pairs, const fs::path& path) {
  const hdf5::Dataset boxes = file.OpenDataset("boxes");
  CheckHead(file, facts, path);
  const std::vector<double> filters = file.OpenDataset("filters").Read();
  protocol::TraceShape shape = ShapeOf(facts);
  std::string run_text;
  if (with_pairs) {
    const std::vector<std::string> texts = file.OpenDataset("run_text").ReadText();
    if (texts.size() != 1 || texts[0].empty()) throw Useless(path, "its 'run_text' is no text");
    run_text = texts[0];
    shape.pairs = facts.pairs;
    shape.text_bytes = run_text.size();
  }
  protocol::TraceMemory trace = protocol::TraceMemory::Create(shape);
  constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
  if (!std::ranges::all_of(filters, [](double bits) { return bits >= 0 && bits <= kMost; }))
    throw Useless(path, "its filters are not what a trace has");
  for (std::size_t i = 0; i < facts.bodies; ++i)
    trace.filters()[i] = {static_cast<std::uint32_t>(filters[i * protocol::kFilterSize]),
                          static_cast<std::uint32_t>(filters[i * protocol::kFilterSize + 1]),
                          static_cast<std::uint32_t>(filters[i * protocol::kFilterSize + 2])};
  for (std::uint64_t cycle = 0; cycle < facts.cycles; ++cycle)
    trace.SetBoxes(cycle, boxes.Read({cycle, 0, 0}, {1, facts.bodies, protocol::kBoxSize}));
  if (with_pairs) FillPairs(file, path, run_text, trace);
  if (shape.primitives) FillMesh(file, path, trace);
  return trace;
}

void CheckHashes(const protocol::TraceMemory& trace, const analysis::TraceFacts& facts,
                 const fs::path& path) {
  if (trace.Sha256() != facts.sha256 ||
      (trace.shape().HasPairs() && trace.PairsSha256() != facts.pairs_sha256))
    throw Useless(path, "it is damaged");
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
    if (trace.shape().primitives) {
      AddText(file, "frame_files", origin.frame_files, "files of the frames of the mesh, in order");
    } else {
      AddText(file, "scenario_text", origin.scenario_text, "the scenario that was recorded");
      AddText(file, "run_text", origin.run_text, "all that decides the run, as YAML");
    }
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
  const bool with_pairs = !check.facts.pairs_sha256.empty();
  const protocol::TraceMemory trace =
      Undamaged(path, [&] { return ReadMemory(file, check.facts, with_pairs, path); });
  CheckHashes(trace, check.facts, path);
  return check;
}

protocol::TraceMemory LoadTrace(const fs::path& path, const std::string& sha256) {
  const hdf5::File file = OpenProvenTrace(path, ProofOf::kFewValues);
  const analysis::TraceFacts facts = Undamaged(path, [&] { return FactsOf(file, path); });
  const bool with_pairs = facts.pairs_sha256 == sha256;
  if (facts.sha256 != sha256 && !with_pairs)
    throw files::StoreError(
        fmt::format("{}: it holds the trace {} and this plan is of {}; plan again, or "
                    "put the other back",
                    path.string(), facts.sha256.substr(0, 16), sha256.substr(0, 16)));
  protocol::TraceMemory trace =
      Undamaged(path, [&] { return ReadMemory(file, facts, with_pairs, path); });
  CheckHashes(trace, facts, path);
  return trace;
}

}  // namespace cdb::results
