#include "runtime/store/shards/reference_shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "compiler/yaml/plan_yaml.h"
#include "dsl/text/check.h"
#include "runtime/store/files/safe_file.h"
#include "runtime/store/files/seal.h"
#include "runtime/store/layout.h"
#include "runtime/store/shards/shard.h"
#include "runtime/store/versions.h"

namespace cdb::shards {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSamplesInAChunk = 1 << 16;

std::vector<std::byte> MakeImage(const std::string& plan_sha256, const plan::Run& run,
                                 const store::RunResult& result, std::span<const double> samples,
                                 const store::Provenance& provenance) {
  hdf5::File file = hdf5::File::CreateInMemory();
  file.SetText("Conventions", store::kConventions);
  file.SetText("schema", store::kSchema);
  file.SetNumber("schema_version", hdf5::Type::kInt32, store::kSchemaVersion);
  file.SetText("plan_sha256", plan_sha256);
  file.SetText("run_id", run.id);
  const auto shape = measure::SampleShapeOf(run.scene);
  CDB_CHECK(shape && samples.size() == shape->Count());
  hdf5::Dataset status = file.CreateDataset({"status", hdf5::Type::kInt8, {1}, {}, 0});
  status.Write({{static_cast<double>(result.status)}});
  status.SetText("long_name", "how the run ended, as that of the measured runs");
  const auto text = [&file](const char* name, const std::string& value, const char* doc) {
    hdf5::Dataset dataset = file.CreateDataset({name, hdf5::Type::kText, {}, {}, 0});
    dataset.WriteText({{value}});
    dataset.SetText("long_name", doc);
  };
  text("message", result.message, "why it did not end well");
  text("state_hash", result.state_hash, "as that of the measured runs");
  text("host", result.host, "the machine that it ran on");
  hdf5::Dataset values =
      file.CreateDataset({"samples",
                          hdf5::Type::kFloat64,
                          {samples.size()},
                          {std::min<std::uint64_t>(samples.size(), kSamplesInAChunk)},
                          0});
  values.Write(samples);
  values.SetText("long_name", "masses and sizes, then states, then observables, in SI units");
  hdf5::Group group = file.CreateGroup("provenance");
  for (const auto& [name, value] : provenance) group.SetText(name.c_str(), value);
  return file.Image();
}

hdf5::File OpenReference(const std::string& plan_sha256, const plan::Run& run,
                         const fs::path& path) {
  hdf5::File file = OpenShard(path);
  if (file.Text("plan_sha256") != plan_sha256 || file.Text("run_id") != run.id)
    throw files::StoreError(fmt::format(
        "{}: is not the reference run {} of this plan; it was left as it is: remove it, and its "
        "run is done again",
        path.string(), run.id));
  return file;
}

/// The numbers of one array of the merged file; the references follow one another.
struct Block {
  hdf5::Shape start, count;
  std::vector<double> values;
};

/// The states and observables of one reference, with their position in the merged file.
Block BlockOf(const ReferenceShard& shard, std::size_t reference, std::string_view array) {
  const measure::SampleShape& shape = shard.shape;
  const bool is_states = array == "states";
  const std::size_t begin = is_states ? shape.State(0, 0) : shape.Observables(0);
  const std::size_t end = is_states ? shape.State(shape.samples, 0) : shape.Count();
  Block block;
  block.start = {reference, 0, 0};
  block.count = {1, shape.samples, measure::kObservableCount};
  if (is_states) {
    block.start = {reference, 0, 0, 0};
    block.count = {1, shape.samples, shape.objects, measure::kStateSize};
  }
  block.values.assign(shard.values.begin() + static_cast<long>(begin),
                      shard.values.begin() + static_cast<long>(end));
  return block;
}

/// The data of all references in the merged file, except their samples.
struct Head {
  std::vector<double> status;
  std::map<std::string, std::vector<std::string>> texts;
};

Head ReadHeads(const plan::Plan& plan, const std::vector<fs::path>& paths, const hdf5::File* base) {
  Head head, there;
  if (base != nullptr) {
    there.status = base->OpenDataset(store::kReferenceGroup + "status").Read();
    for (const char* name : {"message", "state_hash", "host"})
      there.texts[name] = base->OpenDataset(store::kReferenceGroup + name).ReadText();
  }
  const std::string sha256 = plan.Sha256();
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const plan::Run& run = plan.references[i];
    head.texts["role"].emplace_back(RoleName(run.scene.role));
    head.texts["run_text"].push_back(yaml::RunToYaml(run));
    if (paths[i].empty() && base != nullptr) {
      head.status.push_back(there.status.at(i));
      for (const char* name : {"message", "state_hash", "host"})
        head.texts[name].push_back(there.texts[name].at(i));
      continue;
    }
    if (paths[i].empty()) {
      head.status.push_back(static_cast<double>(store::Status::kMissing));
      for (const char* name : {"message", "state_hash", "host"}) head.texts[name].emplace_back();
      continue;
    }
    const hdf5::File shard = OpenReference(sha256, run, paths[i]);
    head.status.push_back(shard.OpenDataset("status").Read().at(0));
    for (const char* name : {"message", "state_hash", "host"})
      head.texts[name].push_back(shard.OpenDataset(name).ReadText().at(0));
  }
  return head;
}

/// The same, read from a merged file.
Block BlockIn(const hdf5::File& base, const std::string& array, std::size_t reference) {
  const hdf5::Dataset dataset = base.OpenDataset(array);
  Block block;
  block.count = dataset.shape();
  block.start.assign(block.count.size(), 0);
  block.start[0] = reference;
  block.count[0] = 1;
  block.values = dataset.Read(block.start, block.count);
  return block;
}

/// Calls `visit(array, block)` for every reference that has samples.
void ForEachBlock(const plan::Plan& plan, const std::vector<fs::path>& paths,
                  const hdf5::File* base,
                  const std::function<void(const std::string&, const Block&)>& visit) {
  const std::string sha256 = plan.Sha256();
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].empty() && base != nullptr)
      for (const char* name : {"states", "observables"})
        visit(store::kReferenceGroup + name, BlockIn(*base, store::kReferenceGroup + name, i));
    if (paths[i].empty()) continue;
    const ReferenceShard shard = ReadReference(sha256, plan.references[i], paths[i]);
    if (shard.values.empty() || shard.shape.objects == 0) continue;
    for (const char* name : {"states", "observables"})
      visit(store::kReferenceGroup + name, BlockOf(shard, i, name));
  }
}

}  // namespace

void WriteReference(const std::string& plan_sha256, const plan::Run& run,
                    const store::RunResult& result, std::span<const double> samples,
                    const store::Provenance& provenance, const fs::path& folder) {
  files::RequireFolder(folder, "shards");
  const fs::path file = folder / (run.id + ".h5");
  try {
    files::WriteSealed(MakeImage(plan_sha256, run, result, samples, provenance), file);
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: cannot be made: {}; nothing was written", file.string(), error.what()));
  }
}

ReferenceShard ReadReference(const std::string& plan_sha256, const plan::Run& run,
                             const fs::path& path) {
  const hdf5::File file = OpenReference(plan_sha256, run, path);
  try {
    ReferenceShard shard;
    shard.status = static_cast<store::Status>(file.OpenDataset("status").Read().at(0));
    shard.message = file.OpenDataset("message").ReadText().at(0);
    shard.shape = *measure::SampleShapeOf(run.scene);
    if (shard.status != store::Status::kDone) return shard;
    shard.values = file.OpenDataset("samples").Read();
    if (shard.values.size() != shard.shape.Count()) throw hdf5::Error("it lacks samples");
    return shard;
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: is no whole shard: {}; it was left as it is: remove it and "
                    "its run is done again",
                    path.string(), error.what()));
  }
}

void MergeReferences(const plan::Plan& plan, const store::Layout& layout,
                     const std::vector<fs::path>& paths, const hdf5::File* base, hdf5::File& file) {
  const Head head = ReadHeads(plan, paths, base);
  file.OpenDataset(layout.Get(store::kReferenceGroup + "status").name).Write(head.status);
  for (const auto& [name, texts] : head.texts)
    file.OpenDataset(store::kReferenceGroup + name).WriteText(texts);
  ForEachBlock(plan, paths, base, [&file](const std::string& name, const Block& block) {
    file.OpenDataset(name).Write(block.start, block.count, block.values);
    file.CheckWritten();
  });
}

void VerifyReferences(const plan::Plan& plan, const store::Layout& layout,
                      const std::vector<fs::path>& paths, const hdf5::File* base,
                      const hdf5::File& file) {
  const auto expect = [](bool is_same, const std::string& name) {
    if (!is_same) throw hdf5::Error(fmt::format("{} did not come back as it was written", name));
  };
  const Head head = ReadHeads(plan, paths, base);
  const std::string status = layout.Get(store::kReferenceGroup + "status").name;
  expect(file.OpenDataset(status).Read() == head.status, status);
  for (const auto& [name, texts] : head.texts)
    expect(file.OpenDataset(store::kReferenceGroup + name).ReadText() == texts,
           store::kReferenceGroup + name);
  ForEachBlock(plan, paths, base, [&](const std::string& name, const Block& block) {
    const auto bytes = [](const std::vector<double>& values) {
      return files::Checksum(std::as_bytes(std::span(values)));
    };
    expect(bytes(file.OpenDataset(name).Read(block.start, block.count)) == bytes(block.values),
           name);
  });
}

}  // namespace cdb::shards
