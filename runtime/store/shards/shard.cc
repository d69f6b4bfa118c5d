// Writes the file of one run: created in memory and written by this code, so that a full disk fails
// in a plain write() and not in HDF5, which cannot close a file that it cannot write.
#include "runtime/store/shards/shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include "compiler/yaml/plan_yaml_writer.h"
#include "dsl/text/check.h"
#include "runtime/store/files/safe_file.h"
#include "runtime/store/layout.h"
#include "runtime/store/proof.h"
#include "runtime/store/shards/prepared_shard.h"
#include "runtime/store/shards/shard_index.h"
#include "runtime/store/shards/shard_template.h"
#include "runtime/store/versions.h"

namespace cdb::shards {
namespace {

/// Rows of the run's contacts: the sum of its series `contacts` over the cycles that ran.
std::uint64_t ContactRows(const plan::Run& run, const store::RunResult& result) {
  if (!run.scene.world.Lists("record", "contacts")) return 0;
  std::uint64_t rows = 0;
  for (const auto& [series, bytes] : result.series) {
    if (series->name != "contacts") continue;
    for (std::size_t i = 0; i < result.n_cycles; ++i) {
      std::int32_t n = 0;
      std::memcpy(&n, &bytes[i * sizeof(n)], sizeof(n));
      rows += static_cast<std::uint64_t>(std::max(n, 0));
    }
  }
  return rows;
}

/// Writes the cycles that ran; the file keeps fill values for the rest.
void WriteSeries(hdf5::File& file, const store::Layout& layout, const plan::Run& run,
                 const store::RunResult& result) {
  const measure::RunExtents extents = measure::ExtentsOf(run.scene);
  for (const auto& [series, bytes] : result.series) {
    CDB_CHECK(bytes.size() == series->ItemBytes() * series->ValueCount(extents));
    const hdf5::Shape inner = series->Extents(extents);
    hdf5::Shape data_shape(layout.grid.size(), 1);
    data_shape.insert(data_shape.end(), inner.begin(), inner.end());
    hdf5::Shape count = data_shape;
    if (const auto cycle = series->CycleDimension())
      count[layout.grid.size() + *cycle] = result.n_cycles;
    hdf5::Dataset dataset = file.OpenDataset(layout.Get(series->name).name);
    dataset.Write(hdf5::Shape(count.size(), 0), count, bytes.data(), data_shape);
  }
}

/// Writes the samples that a run has; the file keeps fill values for the rest.
void WriteErrors(hdf5::File& file, const store::PlanFacts& facts, const store::Layout& layout,
                 const store::RunResult& result) {
  for (const measure::Series& series : facts.error_series) {
    const auto key = series.name.substr(std::string_view(store::kAccuracyGroup).size());
    const auto found = result.errors.values.find(key);
    if (found == result.errors.values.end()) continue;
    hdf5::Shape count(layout.grid.size(), 1);
    count.push_back(found->second.size());
    file.OpenDataset(std::string(series.name))
        .Write(hdf5::Shape(count.size(), 0), count, found->second);
  }
}

/// A killed run may have counted contacts that it did not deliver; their rows hold fill values.
void WriteContacts(hdf5::File& file, const store::RunResult& result, std::uint64_t rows) {
  const std::size_t n = std::min<std::size_t>(rows, result.contacts.size());
  std::vector<std::int32_t> bodies;
  std::vector<double> points, normals, distances;
  for (const measure::ContactRecord& contact : std::span(result.contacts).first(n)) {
    bodies.push_back(static_cast<std::int32_t>(contact.body_a));
    bodies.push_back(static_cast<std::int32_t>(contact.body_b));
    points.insert(points.end(), std::begin(contact.point), std::end(contact.point));
    normals.insert(normals.end(), std::begin(contact.normal), std::end(contact.normal));
    distances.push_back(contact.distance);
  }
  const auto write = [&](const char* name, const auto& values, hdf5::Shape shape) {
    file.OpenDataset(name).Write(hdf5::Shape(shape.size(), 0), shape,
                                 std::as_bytes(std::span(values)).data(), shape);
  };
  write("contact_body", bodies, {n, 2});
  write("contact_point", points, {n, 3});
  write("contact_normal", normals, {n, 3});
  write("contact_distance", distances, {n});
}

/// The most chunks of a series that are looked up one by one, each by a search of all of them.
constexpr std::uint64_t kMostIndexedChunks = 64;

/// The chunks of a flushed file; nullopt if there are too many.
std::optional<std::vector<IndexedChunk>> FindChunks(const hdf5::File& file,
                                                    const store::Layout& layout) {
  std::vector<IndexedChunk> chunks;
  std::uint32_t series = 0;
  const hdf5::Shape cell(layout.grid.size(), 0);
  for (const store::Array& array : layout.arrays) {
    if (array.series == nullptr) continue;
    const std::uint64_t count = store::ChunksOfCell(array, cell.size());
    if (count > kMostIndexedChunks) return std::nullopt;
    const hdf5::Dataset dataset = file.OpenDataset(array.name);
    for (std::uint32_t i = 0; i < count; ++i)
      if (const auto place = dataset.FindChunk(store::ChunkStart(array, cell, i)))
        chunks.push_back({series, i, place->filter_mask, place->begin, place->bytes});
    ++series;
  }
  return chunks;
}

std::vector<std::byte> MakeIndex(std::vector<IndexedChunk> chunks, const store::Layout& layout,
                                 const store::PlanFacts& facts, const plan::Run& run,
                                 const store::RunResult& result,
                                 const store::Provenance& provenance) {
  ShardIndex index;
  index.layout = LayoutChecksum(layout, facts);
  index.info = {run.id, facts.sha256, result.outcome(), result.omitted, result.decisions};
  for (const store::RunNumber& number : facts.numbers)
    index.numbers.push_back(hdf5::AsStored(number.get(result), number.type));
  // HDF5 ends a text at its first NUL.
  for (const store::RunText& text : facts.texts)
    index.texts.emplace_back(text.get(run, result).c_str());
  for (const auto& [name, text] : provenance)
    if (!text.empty()) index.provenance.emplace(name, hdf5::AttributeText(text));
  if (!result.models.empty())
    index.provenance.insert_or_assign("models", std::string(hdf5::AttributeText(result.models)));
  index.chunks = std::move(chunks);
  return IndexBytes(index);
}

/// A copy of a template with the values of the run.
std::vector<std::byte> MakeImage(hdf5::File file, const plan::Plan& plan,
                                 const store::PlanFacts& facts, const store::Layout& layout,
                                 const plan::Run& run, const store::RunResult& result,
                                 const std::string& run_text,
                                 std::optional<std::vector<IndexedChunk>>& chunks) {
  WriteHeadOfRun(file, run);
  WriteCoordinates(file, plan, facts, layout, run);
  WriteSeries(file, layout, run, result);
  if (facts.contacts) {
    WriteContacts(file, result, ContactRows(run, result));
    if (run.scene.world.Lists("record", "contacts"))
      file.OpenDataset("contact_first").Write({{0.0}});
  }
  WriteErrors(file, facts, layout, result);
  for (const store::RunNumber& number : facts.numbers)
    file.OpenDataset(number.name).Write({{number.get(result)}});
  for (const store::RunText& text : facts.texts)
    file.OpenDataset(text.name).WriteText({{text.get(run, result)}});
  file.OpenDataset("provenance/run_text").WriteText({{run_text}});
  if (!result.models.empty()) file.OpenGroup("provenance").SetText("models", result.models);
  std::vector<std::byte> image = file.Image();
  // A merge copies contacts by rows, and needs the HDF5 file for that.
  if (!facts.contacts) chunks = FindChunks(file, layout);
  return image;
}

[[noreturn]] void RefuseShard(const std::filesystem::path& path, std::string_view why) {
  throw files::StoreError(
      fmt::format("{}: is no whole shard: {}; it was left as it is: remove it and its run is done "
                  "again",
                  path.string(), why));
}

}  // namespace

struct ShardWriter::Impl {
  Impl(const plan::Plan& of, const store::Provenance& with)
      : plan(of),
        provenance(with),
        facts(of),
        templates(plan, facts, provenance),
        prepared(plan, facts) {}

  std::vector<std::byte> Make(const plan::Run& run, const store::RunResult& result) const {
    const auto from = templates.Get(run, ContactRows(run, result));
    const std::string run_text = TextOf(run);
    std::vector<std::byte> image;
    std::optional<std::vector<IndexedChunk>> chunks;
    if (auto shard = prepared.Write(from, run, result, run_text)) {
      image = std::move(shard->image);
      chunks = std::move(shard->chunks);
    } else {
      image = MakeImage(hdf5::File::CopyImage(from->image), plan, facts, from->layout, run, result,
                        run_text, chunks);
    }
    if (!chunks) return image;
    const std::vector<std::byte> index =
        MakeIndex(*std::move(chunks), from->layout, facts, run, result, provenance);
    image.insert(image.end(), index.begin(), index.end());
    return image;
  }

  std::string TextOf(const plan::Run& run) const {
    const std::lock_guard lock(text_mutex);
    return text.YamlOf(run);
  }

  const plan::Plan& plan;
  const store::Provenance& provenance;
  const store::PlanFacts facts;
  const ShardTemplates templates;
  mutable PreparedShards prepared;
  mutable std::mutex text_mutex;
  mutable yaml::RunText text{""};
};

ShardWriter::ShardWriter(const plan::Plan& plan, const store::Provenance& provenance)
    : impl_(std::make_unique<const Impl>(plan, provenance)) {}

ShardWriter::~ShardWriter() = default;

void ShardWriter::Write(const plan::Run& run, const store::RunResult& result,
                        const std::filesystem::path& folder) const {
  CDB_CHECK(result.n_cycles <= run.scene.world.Count("cycles"));
  files::RequireFolder(folder, "shards");
  const std::filesystem::path file = folder / (run.id + ".h5");
  try {
    files::WriteSealed(impl_->Make(run, result), file);
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: cannot be made: {}; nothing was written", file.string(), error.what()));
  }
}

void WriteShard(const plan::Plan& plan, const plan::Run& run, const store::RunResult& result,
                const store::Provenance& provenance, const std::filesystem::path& folder) {
  ShardWriter(plan, provenance).Write(run, result, folder);
}

hdf5::File OpenShard(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  try {
    store::ProveShard(path, bytes);
    hdf5::File file = hdf5::File::OpenImage(bytes);
    store::ReadVersion(file, path.string());
    return file;
  } catch (const hdf5::Error& error) {
    RefuseShard(path, error.what());
  }
}

hdf5::File OpenShard(const std::filesystem::path& path) {
  return OpenShard(path, files::ReadSealed(path));
}

ShardInfo ReadShardInfo(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = files::ReadSealed(path);
  if (auto index = FindIndex(bytes)) return std::move(index->info);
  const hdf5::File file = OpenShard(path, bytes);
  try {
    const std::vector<double> status = file.OpenDataset("status").Read();
    const std::string id = file.Text("run_id");
    if (status.size() != 1 || id.empty()) throw hdf5::Error("it does not hold one run");
    // A reference run has no timings that a verdict could void.
    const double verdict = file.Has("verdict") ? file.OpenDataset("verdict").Read().at(0) : 0;
    const int version = store::ReadVersion(file, path.string());
    const auto text = [&](const char* fact) {
      const std::string dataset = store::PathIn(version, fact);
      return file.Has(dataset) ? file.OpenDataset(dataset).ReadText().at(0) : std::string();
    };
    return {id,
            file.Text("plan_sha256"),
            {static_cast<store::Status>(status[0]), static_cast<measure::Verdict>(verdict)},
            text("run/omitted"),
            text("run/needs")};
  } catch (const hdf5::Error& error) {
    RefuseShard(path, error.what());
  }
}

}  // namespace cdb::shards
