#include "runtime/results/journal/references.h"

#include <fmt/format.h>

#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/journal/run_writer.h"

namespace cdb::journal {
namespace {

/// The numbers of one array of the merged file; the references follow one another.
struct Block {
  hdf5::Shape start, count;
  std::vector<double> values;
};

/// The states and observables of one reference, with their position in the merged file.
Block BlockOf(const Reference& run, std::size_t reference, std::string_view array) {
  const protocol::SampleShape& shape = run.shape;
  const bool is_states = array == "states";
  const std::size_t begin = is_states ? shape.State(0, 0) : shape.Observables(0);
  const std::size_t end = is_states ? shape.State(shape.samples, 0) : shape.Count();
  Block block;
  block.start = {reference, 0, 0};
  block.count = {1, shape.samples, protocol::kObservableCount};
  if (is_states) {
    block.start = {reference, 0, 0, 0};
    block.count = {1, shape.samples, shape.objects, protocol::kStateSize};
  }
  block.values.assign(run.values.begin() + static_cast<long>(begin),
                      run.values.begin() + static_cast<long>(end));
  return block;
}

/// The data of all references in the merged file, except their samples.
struct Head {
  std::vector<double> status;
  std::map<std::string, std::vector<std::string>> texts;
};

Head ReadHeads(const plan::Plan& plan, Journals& journals, const hdf5::File* base) {
  constexpr const char* kTexts[] = {"message", "state_hash", "host"};
  Head head, there;
  if (base != nullptr) {
    there.status = base->OpenDataset(results::kReferenceGroup + "status").Read();
    for (const char* name : kTexts)
      there.texts[name] = base->OpenDataset(results::kReferenceGroup + name).ReadText();
  }
  for (std::size_t i = 0; i < plan.references.size(); ++i) {
    const plan::Run& run = plan.references[i];
    head.texts["role"].emplace_back(RoleName(run.scene.role));
    head.texts["run_text"].push_back(yaml::RunToYaml(run));
    const auto record = journals.Find(run.id);
    head.status.push_back(record            ? record->Number("status").value_or(0)
                          : base != nullptr ? there.status.at(i)
                                            : static_cast<double>(results::Status::kMissing));
    for (const char* name : kTexts)
      head.texts[name].push_back(record            ? record->Text(name)
                                 : base != nullptr ? there.texts[name].at(i)
                                                   : std::string());
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
void ForEachBlock(const plan::Plan& plan, Journals& journals, const hdf5::File* base,
                  const std::function<void(const std::string&, const Block&)>& visit) {
  for (std::size_t i = 0; i < plan.references.size(); ++i) {
    const auto record = journals.Find(plan.references[i].id);
    if (!record && base != nullptr)
      for (const char* name : {"states", "observables"})
        visit(results::kReferenceGroup + name, BlockIn(*base, results::kReferenceGroup + name, i));
    if (!record) continue;
    const Reference run = ReadReference(plan.references[i], *record);
    if (run.values.empty() || run.shape.objects == 0) continue;
    for (const char* name : {"states", "observables"})
      visit(results::kReferenceGroup + name, BlockOf(run, i, name));
  }
}

}  // namespace

void MergeReferences(const plan::Plan& plan, const results::Layout& layout, Journals& journals,
                     const hdf5::File* base, hdf5::File& file) {
  const Head head = ReadHeads(plan, journals, base);
  file.OpenDataset(layout.Get(results::kReferenceGroup + "status").name).Write(head.status);
  for (const auto& [name, texts] : head.texts)
    file.OpenDataset(results::kReferenceGroup + name).WriteText(texts);
  ForEachBlock(plan, journals, base, [&file](const std::string& name, const Block& block) {
    file.OpenDataset(name).Write(block.start, block.count, block.values);
    file.CheckWritten();
  });
}

void VerifyReferences(const plan::Plan& plan, const results::Layout& layout, Journals& journals,
                      const hdf5::File* base, const hdf5::File& file) {
  const auto expect = [](bool is_same, const std::string& name) {
    if (!is_same) throw hdf5::Error(fmt::format("{} did not come back as it was written", name));
  };
  const Head head = ReadHeads(plan, journals, base);
  const std::string status = layout.Get(results::kReferenceGroup + "status").name;
  expect(file.OpenDataset(status).Read() == head.status, status);
  for (const auto& [name, texts] : head.texts)
    expect(file.OpenDataset(results::kReferenceGroup + name).ReadText() == texts,
           results::kReferenceGroup + name);
  ForEachBlock(plan, journals, base, [&](const std::string& name, const Block& block) {
    const auto bytes = [](const std::vector<double>& values) {
      return files::Checksum(std::as_bytes(std::span(values)));
    };
    expect(bytes(file.OpenDataset(name).Read(block.start, block.count)) == bytes(block.values),
           name);
  });
}

}  // namespace cdb::journal
