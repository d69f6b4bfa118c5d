#include "runtime/results/journal/run_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/analysis/reference.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/text/check.h"
#include "runtime/protocol/samples.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/hdf5/filters.h"

namespace cdb::journal {
namespace {

constexpr std::uint64_t kSamplesInAChunk = 1 << 16;
constexpr const char* kReferenceTexts[] = {"message", "state_hash", "host", "verdict"};

/// Copies the block `count` from one array of items to another; `from` and `to` are the first
/// elements, and the shapes those of the arrays.
class BlockCopy {
 public:
  BlockCopy(const std::byte* from_array, const hdf5::Shape& from_shape, const hdf5::Shape& from,
            std::byte* to_array, const hdf5::Shape& to_shape, const hdf5::Shape& count,
            std::size_t item_bytes)
      : from_shape_(from_shape),
        to_shape_(to_shape),
        from_(from),
        count_(count),
        item_bytes_(item_bytes) {
    Copy(0, from_array, to_array);
  }

 private:
  void Copy(std::size_t d, const std::byte* source, std::byte* target) const {
    std::uint64_t source_step = item_bytes_, target_step = item_bytes_;
    for (std::size_t i = d + 1; i < count_.size(); ++i) {
      source_step *= from_shape_[i];
      target_step *= to_shape_[i];
    }
    source += from_[d] * source_step;
    if (d + 1 == count_.size()) {
      std::memcpy(target, source, count_[d] * item_bytes_);
      return;
    }
    for (std::uint64_t i = 0; i < count_[d]; ++i)
      Copy(d + 1, source + i * source_step, target + i * target_step);
  }

  const hdf5::Shape &from_shape_, &to_shape_, &from_, &count_;
  const std::size_t item_bytes_;
};

std::vector<std::byte> FillChunk(const results::Array& array, std::size_t items) {
  const std::size_t item_bytes = hdf5::ItemBytes(array.type);
  std::vector<std::byte> bytes(items * item_bytes);
  const auto whole = static_cast<std::int32_t>(hdf5::AsStored(array.fill, hdf5::Type::kInt32));
  const void* fill = array.type == hdf5::Type::kInt32 ? static_cast<const void*>(&whole)
                                                      : static_cast<const void*>(&array.fill);
  for (std::size_t i = 0; i < items; ++i) std::memcpy(&bytes[i * item_bytes], fill, item_bytes);
  return bytes;
}

/// Adds the chunks that hold the first `count` of each dimension of `data`, an array of the shape
/// `data_shape`, as HDF5 would store them: other values of these chunks are fill values. `index`:
/// of the array in the record. All shapes are those within a cell, of `outer` dimensions.
void AddChunks(const results::Array& array, std::size_t outer, std::uint32_t index,
               const std::byte* data, const hdf5::Shape& data_shape, const hdf5::Shape& count,
               Record& record) {
  const auto inner = [outer](const hdf5::Shape& shape) {
    return hdf5::Shape(shape.begin() + static_cast<std::ptrdiff_t>(outer), shape.end());
  };
  if (hdf5::Product(count) == 0) return;
  const hdf5::Shape chunk = inner(array.chunk), cell(outer, 0);
  const std::size_t item_bytes = hdf5::ItemBytes(array.type), items = hdf5::Product(chunk);
  if (chunk == data_shape && chunk == count)
    return record.Add(index, 0, hdf5::Filtered({data, items * item_bytes}, item_bytes));
  const std::uint64_t chunks = results::ChunksOfCell(array, outer);
  for (std::uint32_t i = 0; i < chunks; ++i) {
    const hdf5::Shape start = inner(results::ChunkStart(array, cell, i));
    hdf5::Shape part = chunk;
    bool is_there = true;
    for (std::size_t d = 0; d < part.size(); ++d) {
      is_there = is_there && start[d] < count[d];
      if (is_there) part[d] = std::min(part[d], count[d] - start[d]);
    }
    if (!is_there) continue;
    std::vector<std::byte> bytes = FillChunk(array, items);
    BlockCopy(data, data_shape, start, bytes.data(), chunk, part, item_bytes);
    record.Add(index, i, hdf5::Filtered(bytes, item_bytes));
  }
}

/// Rows of the run's contacts: the sum of its series `contacts` over the cycles that ran.
std::uint64_t ContactRows(const results::RunResult& result) {
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

/// HDF5 ends a text at its first NUL.
std::string AsText(const std::string& text) { return text.c_str(); }

results::Provenance AsAttributes(const results::Provenance& provenance) {
  results::Provenance attributes;
  for (const auto& [name, text] : provenance)
    if (!text.empty()) attributes.emplace(name, hdf5::AttributeText(text));
  return attributes;
}

About HeadOf(const results::Layout& layout, const results::PlanFacts& facts) {
  About about;
  const auto inner = [&](const hdf5::Shape& shape) {
    return hdf5::Shape(shape.begin() + static_cast<std::ptrdiff_t>(layout.grid.size()),
                       shape.end());
  };
  for (const results::Array& array : layout.arrays)
    if (array.series != nullptr)
      about.arrays.push_back({array.name, array.type, inner(array.shape), inner(array.chunk)});
  for (const results::RunNumber& number : facts.numbers) about.numbers.push_back(number.name);
  for (const results::RunText& text : facts.texts) about.texts.push_back(text.name);
  if (facts.contacts) {
    about.numbers.emplace_back(kContactRows);
    for (const char* name : kContactArrays)
      about.arrays.push_back({name, layout.Get(name).type, {}, {}});
  }
  return about;
}

/// Values as an array of `type` stores them.
std::vector<std::byte> AsItems(const std::vector<double>& values, hdf5::Type type) {
  if (type != hdf5::Type::kInt32) {
    const auto bytes = std::as_bytes(std::span(values));
    return {bytes.begin(), bytes.end()};
  }
  std::vector<std::byte> bytes(values.size() * sizeof(std::int32_t));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto whole = static_cast<std::int32_t>(values[i]);
    std::memcpy(&bytes[i * sizeof whole], &whole, sizeof whole);
  }
  return bytes;
}

}  // namespace

RunWriter::RunWriter(const plan::Plan& plan, const results::Provenance& provenance)
    : plan_(plan),
      provenance_(provenance),
      facts_(plan),
      layout_(results::MakeLayout(plan, facts_, 0)),
      head_(HeadOf(layout_, facts_)) {}

std::shared_ptr<const About> RunWriter::AboutFor(results::Provenance provenance) {
  constexpr std::size_t kMost = 1000;
  if (abouts_.size() >= kMost) abouts_.clear();
  std::shared_ptr<const About>& about = abouts_[provenance];
  if (about != nullptr) return about;
  About made = head_;
  made.provenance = AsAttributes(provenance);
  return about = std::make_shared<const About>(std::move(made));
}

void RunWriter::AddSeries(const plan::Run& run, const results::RunResult& result,
                          Record& record) const {
  const protocol::RunExtents extents = protocol::ExtentsOf(run.scene);
  const std::size_t outer = layout_.grid.size();
  std::uint32_t index = 0;
  for (const results::Array& array : layout_.arrays) {
    if (array.series == nullptr) continue;
    const auto found = std::ranges::find(result.series, array.series,
                                         [](const auto& series) { return series.first; });
    if (found != result.series.end()) {
      const auto& [series, bytes] = *found;
      CDB_CHECK(bytes.size() == series->ItemBytes() * series->ValueCount(extents));
      const hdf5::Shape shape = series->Extents(extents);
      hdf5::Shape count = shape;
      if (const auto cycle = series->CycleDimension()) count[*cycle] = result.n_cycles;
      AddChunks(array, outer, index, bytes.data(), shape, count, record);
    } else if (array.name.starts_with(results::kAccuracyGroup)) {
      const auto samples =
          result.errors.values.find(array.name.substr(results::kAccuracyGroup.size()));
      if (samples != result.errors.values.end())
        AddChunks(array, outer, index, std::as_bytes(std::span(samples->second)).data(),
                  {samples->second.size()}, {samples->second.size()}, record);
    }
    ++index;
  }
}

/// A killed run may have counted contacts that it did not deliver; their rows hold fill values.
void RunWriter::AddContacts(const plan::Run& run, const results::RunResult& result,
                            Record& record) const {
  if (!run.scene.world.Lists("record", "contacts")) return;
  const std::uint64_t rows = ContactRows(result);
  record.numbers.back() = static_cast<double>(rows);
  std::vector<std::int32_t> bodies(2 * rows, -1);
  std::vector<double> points(3 * rows, results::kNaN), normals = points,
                                                       distances(rows, results::kNaN);
  for (std::size_t i = 0; i < std::min<std::size_t>(rows, result.contacts.size()); ++i) {
    const protocol::ContactRecord& contact = result.contacts[i];
    bodies[2 * i] = static_cast<std::int32_t>(contact.body_a);
    bodies[2 * i + 1] = static_cast<std::int32_t>(contact.body_b);
    std::copy_n(contact.point, 3, &points[3 * i]);
    std::copy_n(contact.normal, 3, &normals[3 * i]);
    distances[i] = contact.distance;
  }
  if (rows == 0) return;
  auto index = static_cast<std::uint32_t>(record.about->arrays.size() - std::size(kContactArrays));
  const auto add = [&](const auto& values) {
    record.Add(index++, 0, hdf5::Filtered(std::as_bytes(std::span(values)), sizeof values[0]));
  };
  add(bodies);
  add(points);
  add(normals);
  add(distances);
}

void RunWriter::Write(const plan::Run& run, const results::RunResult& result, Journal& journal) {
  CDB_CHECK(result.n_cycles <= run.scene.world.Count("cycles"));
  Record record;
  record.run_id = run.id;
  results::Provenance provenance = provenance_;
  provenance["precision"] = run.scene.world.WordOr("precision");
  if (!result.models.empty()) provenance["models"] = result.models;
  record.about = AboutFor(std::move(provenance));
  for (const results::RunNumber& number : facts_.numbers)
    record.numbers.push_back(hdf5::AsStored(number.get(result), number.type));
  for (const results::RunText& text : facts_.texts)
    record.texts.push_back(AsText(text.get(run, result)));
  if (facts_.contacts) record.numbers.push_back(results::kNaN);
  AddSeries(run, result, record);
  if (facts_.contacts) AddContacts(run, result, record);
  journal.Write(record);
}

Record RunWriter::Copy(const plan::Run& run, const MergeBase& from, std::size_t cell,
                       const std::string& id_there) {
  Record record;
  record.run_id = run.id;
  record.about = AboutFor(from.ProvenanceOf(id_there));
  for (std::size_t i = 0; i < facts_.numbers.size(); ++i)
    record.numbers.push_back(from.Number(i, cell));
  for (std::size_t i = 0; i < facts_.texts.size(); ++i)
    record.texts.push_back(facts_.texts[i].name == "run/run_id" ? run.id : from.Text(i, cell));
  if (facts_.contacts) record.numbers.push_back(results::kNaN);
  CopySeries(run, from, cell, record);
  if (facts_.contacts) CopyContacts(from, cell, record);
  return record;
}

/// Other runs of the plan of `from` may have had more cycles or bodies.
void RunWriter::CopySeries(const plan::Run& run, const MergeBase& from, std::size_t cell,
                           Record& record) const {
  const protocol::RunExtents extents = protocol::ExtentsOf(run.scene);
  const auto sampling = analysis::SamplingOf(run.scene);
  std::uint32_t index = 0;
  for (const results::Array& array : layout_.arrays) {
    if (array.series == nullptr) continue;
    const std::uint32_t place = index++;
    const bool is_error = array.name.starts_with(results::kAccuracyGroup);
    if (is_error ? !sampling : !protocol::IsRecordedBy(*array.series, run.scene)) continue;
    if (!from.file().Has(array.name)) continue;
    const hdf5::Dataset source = from.file().OpenDataset(array.name);
    hdf5::Shape count =
        is_error ? hdf5::Shape{sampling->count} : hdf5::Shape(array.series->Extents(extents));
    if (const auto cycle = array.series->CycleDimension())
      count[*cycle] = static_cast<std::uint64_t>(std::max(0.0, record.Number("n_cycles").value()));
    const std::size_t outer = source.shape().size() - count.size();
    if (source.type() != array.type || source.shape().size() < count.size())
      throw hdf5::Error(fmt::format("{} of the file has another shape", array.name));
    if (hdf5::Product(count) == 0) continue;
    hdf5::Shape start =
                    results::CellAt({source.shape().begin(),
                                     source.shape().begin() + static_cast<std::ptrdiff_t>(outer)},
                                    cell),
                block(outer, 1);
    start.resize(source.shape().size());
    block.insert(block.end(), count.begin(), count.end());
    const std::vector<std::byte> bytes = AsItems(source.Read(start, block), array.type);
    AddChunks(array, layout_.grid.size(), place, bytes.data(), count, count, record);
  }
}

void RunWriter::CopyContacts(const MergeBase& from, std::size_t cell, Record& record) const {
  const auto rows = from.ContactRows(cell);
  if (!rows) return;
  record.numbers.back() = static_cast<double>(rows->count);
  if (rows->count == 0) return;
  auto index = static_cast<std::uint32_t>(record.about->arrays.size() - std::size(kContactArrays));
  for (const char* name : kContactArrays) {
    const hdf5::Dataset source = from.file().OpenDataset(name);
    hdf5::Shape start(source.shape().size(), 0), count = source.shape();
    start[0] = rows->first;
    count[0] = rows->count;
    record.Add(index++, 0,
               hdf5::Filtered(AsItems(source.Read(start, count), source.type()),
                              hdf5::ItemBytes(source.type())));
  }
}

/// Why a reference is not sound: `drifting from 0.35 s on, 3 objects`.
std::string FaultOf(const plan::Run& run, const results::RunResult& result) {
  const protocol::Judgement& judgement = result.judgement;
  if (result.status != results::Status::kDone || judgement.verdict <= protocol::Verdict::kStable)
    return {};
  std::string text = protocol::VerdictText(judgement);
  if (judgement.first_bad_cycle >= 0)
    text += fmt::format(" from {:.3g} s on", static_cast<double>(judgement.first_bad_cycle + 1) *
                                                 run.scene.world.Real("timestep"));
  if (judgement.bad_objects >= 0)
    text +=
        fmt::format(", {} object{}", judgement.bad_objects, judgement.bad_objects == 1 ? "" : "s");
  return text;
}

void RunWriter::WriteReference(const plan::Run& run, const results::RunResult& result,
                               std::span<const double> samples, Journal& journal) {
  const auto shape = protocol::SampleShapeOf(run.scene);
  CDB_CHECK(shape && samples.size() == shape->Count());
  if (of_references_ == nullptr || of_references_->arrays[0].shape[0] != samples.size()) {
    About about;
    about.arrays = {{"samples", hdf5::Type::kFloat64, {samples.size()}, {kSamplesInAChunk}}};
    about.numbers = {"status"};
    about.texts.assign(std::begin(kReferenceTexts), std::end(kReferenceTexts));
    about.provenance = AsAttributes(provenance_);
    of_references_ = std::make_shared<const About>(std::move(about));
  }
  Record record;
  record.run_id = run.id;
  record.about = of_references_;
  record.numbers = {static_cast<double>(result.status)};
  const std::string verdict(protocol::VerdictName(result.judgement.verdict));
  for (const std::string& text :
       {result.message + FaultOf(run, result), result.state_hash, result.host, verdict})
    record.texts.push_back(AsText(text));
  std::uint32_t index = 0;
  for (std::size_t at = 0; at < samples.size(); at += kSamplesInAChunk)
    record.Add(
        0, index++,
        hdf5::Filtered(std::as_bytes(samples.subspan(
                           at, std::min<std::size_t>(samples.size() - at, kSamplesInAChunk))),
                       sizeof(double)));
  journal.Write(record);
}

Reference ReadReference(const plan::Run& run, const Record& record) {
  const auto shape = protocol::SampleShapeOf(run.scene);
  if (!shape || record.run_id != run.id || record.about->arrays.size() != 1 ||
      record.about->arrays[0].name != "samples")
    throw hdf5::Error("it is not the record of that reference run");
  Reference reference;
  reference.status = InfoOf(record).outcome.status;
  reference.message = record.Text("message");
  reference.shape = *shape;
  if (reference.status != results::Status::kDone) return reference;
  std::span<const std::byte> left(record.bytes);
  reference.values.resize(shape->Count());
  std::size_t at = 0;
  for (const Record::Chunk& chunk : record.chunks) {
    const std::size_t n = std::min<std::size_t>(reference.values.size() - at, kSamplesInAChunk);
    const std::vector<std::byte> values =
        hdf5::Unfiltered(left.first(chunk.bytes), sizeof(double), n * sizeof(double));
    std::memcpy(reference.values.data() + at, values.data(), values.size());
    left = left.subspan(chunk.bytes);
    at += n;
  }
  if (at != reference.values.size()) throw hdf5::Error("it lacks samples");
  return reference;
}

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

/// The references that a merge base holds.
class ReferencesOf {
 public:
  /// `base`: null if there is none.
  explicit ReferencesOf(const hdf5::File* base) : base_(base) {
    if (base == nullptr || !base->Has(results::kReferenceGroup + "reference")) return;
    const std::vector<std::string> ids =
        base->OpenDataset(results::kReferenceGroup + "reference").ReadText();
    for (std::size_t i = 0; i < ids.size(); ++i) places_.emplace(ids[i], i);
    status_ = base->OpenDataset(results::kReferenceGroup + "status").Read();
    // Files written by earlier versions lack some of the texts.
    for (const char* name : kReferenceTexts)
      if (base->Has(results::kReferenceGroup + name))
        texts_[name] = base->OpenDataset(results::kReferenceGroup + name).ReadText();
  }
  const hdf5::File& file() const { return *base_; }
  std::optional<std::size_t> PlaceOf(const std::string& id) const {
    const auto found = places_.find(id);
    return found == places_.end() ? std::nullopt : std::optional(found->second);
  }
  double Status(std::size_t place) const { return status_.at(place); }
  std::string Text(const std::string& name, std::size_t place) const {
    const auto found = texts_.find(name);
    return found == texts_.end() ? std::string() : found->second.at(place);
  }

 private:
  const hdf5::File* base_;
  std::map<std::string, std::size_t> places_;
  std::vector<double> status_;
  std::map<std::string, std::vector<std::string>> texts_;
};

/// The data of all references in the merged file, except their samples.
struct Head {
  std::vector<double> status;
  std::map<std::string, std::vector<std::string>> texts;
};

Head ReadHeads(const plan::Plan& plan, Journals& journals, const ReferencesOf& base) {
  Head head;
  for (const plan::Run& run : plan.references) {
    head.texts["role"].emplace_back(RoleName(run.scene.role));
    head.texts["run_text"].push_back(yaml::RunToYaml(run));
    const auto record = journals.Find(run.id);
    const auto place = record ? std::nullopt : base.PlaceOf(run.id);
    head.status.push_back(record  ? record->Number("status").value_or(0)
                          : place ? base.Status(*place)
                                  : static_cast<double>(results::Status::kMissing));
    for (const char* name : kReferenceTexts)
      head.texts[name].push_back(record  ? record->Text(name)
                                 : place ? base.Text(name, *place)
                                         : std::string());
  }
  return head;
}

/// The samples of one reference, read from a merged file where it has the index `from`.
Block BlockIn(const hdf5::File& base, const std::string& array, std::size_t from,
              std::size_t reference) {
  const hdf5::Dataset dataset = base.OpenDataset(array);
  Block block;
  block.count = dataset.shape();
  block.start.assign(block.count.size(), 0);
  block.start[0] = from;
  block.count[0] = 1;
  block.values = dataset.Read(block.start, block.count);
  block.start[0] = reference;
  return block;
}

/// Calls `visit(array, block)` for every reference that has samples.
void ForEachBlock(const plan::Plan& plan, Journals& journals, const ReferencesOf& base,
                  const std::function<void(const std::string&, const Block&)>& visit) {
  for (std::size_t i = 0; i < plan.references.size(); ++i) {
    const auto record = journals.Find(plan.references[i].id);
    if (const auto place = base.PlaceOf(plan.references[i].id); !record && place)
      for (const char* name : {"states", "observables"})
        visit(results::kReferenceGroup + name,
              BlockIn(base.file(), results::kReferenceGroup + name, *place, i));
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
  const ReferencesOf there(base);
  const Head head = ReadHeads(plan, journals, there);
  file.OpenDataset(layout.Get(results::kReferenceGroup + "status").name).Write(head.status);
  for (const auto& [name, texts] : head.texts)
    file.OpenDataset(results::kReferenceGroup + name).WriteText(texts);
  ForEachBlock(plan, journals, there, [&file](const std::string& name, const Block& block) {
    file.OpenDataset(name).Write(block.start, block.count, block.values);
    file.CheckWritten();
  });
}

void VerifyReferences(const plan::Plan& plan, const results::Layout& layout, Journals& journals,
                      const hdf5::File* base, const hdf5::File& file) {
  const auto expect = [](bool is_same, const std::string& name) {
    if (!is_same) throw hdf5::Error(fmt::format("{} did not come back as it was written", name));
  };
  const ReferencesOf there(base);
  const Head head = ReadHeads(plan, journals, there);
  const std::string status = layout.Get(results::kReferenceGroup + "status").name;
  expect(file.OpenDataset(status).Read() == head.status, status);
  for (const auto& [name, texts] : head.texts)
    expect(file.OpenDataset(results::kReferenceGroup + name).ReadText() == texts,
           results::kReferenceGroup + name);
  ForEachBlock(plan, journals, there, [&](const std::string& name, const Block& block) {
    const auto bytes = [](const std::vector<double>& values) {
      return files::Checksum(std::as_bytes(std::span(values)));
    };
    expect(bytes(file.OpenDataset(name).Read(block.start, block.count)) == bytes(block.values),
           name);
  });
}

}  // namespace cdb::journal
