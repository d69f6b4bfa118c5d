// Merges many shards into one file without decoding values: chunks are copied as stored, filtered.
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/store/examine.h"
#include "runtime/store/files/limited_process.h"
#include "runtime/store/files/safe_file.h"
#include "runtime/store/files/seal.h"
#include "runtime/store/files/temporary_file.h"
#include "runtime/store/layout.h"
#include "runtime/store/layout_file.h"
#include "runtime/store/merged_provenance.h"
#include "runtime/store/proof.h"
#include "runtime/store/shards/merge_base.h"
#include "runtime/store/shards/reference_shard.h"
#include "runtime/store/shards/shard.h"
#include "runtime/store/shards/shard_index.h"
#include "runtime/store/shards/shard_places.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"
#include "runtime/store/versions.h"

namespace cdb::shards {
namespace {

namespace fs = std::filesystem;

/// A chunk that the merged file must hold.
struct CopiedChunk {
  std::uint32_t series;  ///< index in Merger::series_
  std::uint32_t chunk;   ///< index within the cell
  std::size_t cell;
  std::uint64_t checksum;
};

/// The same for rows of a contact array.
struct CopiedRows {
  const char* array;
  hdf5::Shape start, count;
  std::uint64_t checksum;  ///< of the values converted to doubles
};

/// A run, by its id, and every cell of the grid that it fills.
struct Cells {
  std::string run_id;
  std::vector<std::size_t> cells;
};

/// A shard in the merge without a usable index.
struct Source {
  const hdf5::File& file;
  int version;

  /// Nullopt if the cdb that wrote the shard did not have the array; the merged file then keeps
  /// fill values. A shard is proven to be as it was written, so that nothing else can be missing.
  std::optional<hdf5::Dataset> Open(const std::string& path) const {
    const std::string there = store::PathIn(version, path);
    if (!file.Has(there)) return std::nullopt;
    return file.OpenDataset(there);
  }
};

std::size_t FlatIndex(const hdf5::Shape& grid, const std::vector<std::size_t>& at,
                      std::uint64_t rep) {
  std::size_t index = 0;
  for (std::size_t i = 0; i < at.size(); ++i) index = index * grid[i] + at[i];
  return index * grid.back() + rep;
}

hdf5::Shape Unflatten(const hdf5::Shape& grid, std::size_t index) {
  hdf5::Shape cell(grid.size());
  for (std::size_t i = grid.size(); i-- > 0; index /= grid[i]) cell[i] = index % grid[i];
  return cell;
}

class Merger {
 public:
  /// `base`: empty, or the file with the runs that have no shard.
  Merger(const plan::Plan& plan, const store::Provenance& provenance,
         const std::vector<fs::path>& shards, const fs::path& base)
      : plan_(plan), provenance_(provenance), places_(shards), facts_(plan) {
    if (!base.empty()) base_.emplace(base, facts_);
    hdf5::Shape grid;
    for (const plan::Axis& axis : plan.axes) grid.push_back(axis.values.size());
    grid.push_back(plan.repeats);
    FindRuns(grid);
    PlaceContacts(hdf5::Product(grid));
    layout_ = store::MakeLayout(plan, facts_, nullptr, contact_rows_);
    for (const store::Array& array : layout_.arrays)
      if (array.series != nullptr) series_.push_back(&array);
    layout_checksum_ = LayoutChecksum(layout_, facts_);
    is_cut_known_.assign(series_.size(), false);
    for (const store::RunNumber& number : facts_.numbers)
      numbers_.emplace_back(hdf5::Product(grid), number.missing);
    for (const store::RunText& text : facts_.texts) {
      texts_.emplace_back(hdf5::Product(grid));
      if (text.name != "run/run_id") continue;
      for (const Cells& cells : runs_)
        for (const std::size_t cell : cells.cells) texts_.back()[cell] = cells.run_id;
    }
    plan.ForEachSkipped([&](const std::vector<std::size_t>& point) {
      for (std::uint64_t rep = 0; rep < plan.repeats; ++rep)
        numbers_[0][FlatIndex(grid, point, rep)] = static_cast<double>(store::Status::kSkipped);
    });
  }

  void Write(const fs::path& path) {
    hdf5::File file = hdf5::File::Create(path);
    store::CreateArrays(file, layout_);
    const std::size_t merged = CopyShards(file);
    store::WriteHead(file, plan_, facts_,
                     fmt::format("merged {} of {} runs", merged, runs_.size()));
    file.SetText(store::kDigestAttribute, store::kDigestText);
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      file.OpenDataset(facts_.numbers[i].name).Write(numbers_[i]);
    for (std::size_t i = 0; i < texts_.size(); ++i)
      file.OpenDataset(facts_.texts[i].name).WriteText(texts_[i]);
    if (!plan_.references.empty())
      MergeReferences(plan_, layout_, ReferencePaths(), base_ ? &base_->file() : nullptr, file);
    if (facts_.contacts) file.OpenDataset("contact_first").Write(contact_first_);
    WriteProvenance(file);
    file.Close();
  }

  /// Reads the closed file back and compares it with the data from the shards.
  void Verify(const fs::path& path) const {
    const hdf5::File file = hdf5::File::Open(path);
    std::vector<hdf5::Dataset> series;
    for (const store::Array* array : series_) series.push_back(file.OpenDataset(array->name));
    hdf5::RawChunk chunk;
    for (const CopiedChunk& copied : copied_) {
      const store::Array& array = *series_[copied.series];
      const hdf5::Shape cell = Unflatten(layout_.grid, copied.cell);
      if (!series[copied.series].ReadChunk(store::ChunkStart(array, cell, copied.chunk), chunk) ||
          files::Checksum(chunk.bytes) != copied.checksum)
        throw hdf5::Error(fmt::format("{} did not come back as it was written", array.name));
    }
    for (const CopiedRows& copied : copied_rows_) {
      const std::vector<double> values =
          file.OpenDataset(copied.array).Read(copied.start, copied.count);
      if (files::Checksum(std::as_bytes(std::span(values))) != copied.checksum)
        throw hdf5::Error(fmt::format("{} did not come back as it was written", copied.array));
    }
    if (facts_.contacts &&
        !std::ranges::equal(file.OpenDataset("contact_first").Read(), contact_first_, SameBits))
      throw hdf5::Error("contact_first did not come back as it was written");
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      const std::string& name = facts_.numbers[i].name;
      const std::vector<double> values = file.OpenDataset(name).Read();
      if (!std::ranges::equal(values, numbers_[i], SameBits))
        throw hdf5::Error(fmt::format("{} did not come back as it was written", name));
    }
    if (!plan_.references.empty())
      VerifyReferences(plan_, layout_, ReferencePaths(), base_ ? &base_->file() : nullptr, file);
    for (std::size_t i = 0; i < texts_.size(); ++i) {
      const std::string& name = facts_.texts[i].name;
      if (file.OpenDataset(name).ReadText() != texts_[i])
        throw hdf5::Error(fmt::format("{} did not come back as it was written", name));
    }
  }

  /// Chunks are copied without being decoded. Checks that those of `path` can be read and hold
  /// valid values, if there are not too many.
  void Prove(const fs::path& path) const {
    const std::uintmax_t bytes = fs::file_size(path);
    if (bytes > store::kMostProven) return;
    const std::string why =
        files::RunLimited([&] { store::CheckAllValues(hdf5::File::Open(path), extents()); },
                          files::LimitsForFile(bytes));
    if (!why.empty()) throw hdf5::Error(why);
  }

 private:
  static constexpr const char* kContactArrays[] = {"contact_body", "contact_point",
                                                   "contact_normal", "contact_distance"};

  static bool SameBits(double a, double b) { return a == b || (a != a && b != b); }

  void FindRuns(const hdf5::Shape& grid) {
    std::unordered_map<std::string, std::size_t> index;
    plan_.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
      const auto [found, is_new] = index.try_emplace(id, runs_.size());
      if (is_new) runs_.push_back({id, {}});
      runs_[found->second].cells.push_back(FlatIndex(grid, at, rep));
    });
  }

  /// The path of the shard of each reference; empty if there is none.
  std::vector<fs::path> ReferencePaths() const {
    std::vector<fs::path> paths;
    for (const plan::Run& reference : plan_.references)
      paths.push_back(places_.Find(reference.id).value_or(fs::path()));
    return paths;
  }

  /// `plan_sha256` and `run_id`: as stated in the shard at `path`.
  void CheckIsOf(const std::string& wanted, const fs::path& path, const std::string& plan_sha256,
                 const std::string& run_id) const {
    if (plan_sha256 != facts_.sha256)
      throw files::StoreError(fmt::format(
          "{}: belongs to another plan than `{}`; nothing was merged, and it was left as it is: "
          "start over with --fresh, or choose another name (-o)",
          path.string(), plan_.benchmark));
    if (run_id != wanted)
      throw files::StoreError(
          fmt::format("{}: holds the run {} under another name; nothing was merged: "
                      "rename or remove it",
                      path.string(), run_id));
  }

  hdf5::File OpenOf(const std::string& wanted, const fs::path& path,
                    std::span<const std::byte> bytes) const {
    hdf5::File shard = OpenShard(path, bytes);
    CheckIsOf(wanted, path, shard.Text("plan_sha256"), shard.Text("run_id"));
    return shard;
  }

  struct ShardContacts {
    bool are_recorded = false;
    std::uint64_t rows = 0;
  };
  static ShardContacts ContactsOf(const hdf5::File& shard, const fs::path& path) {
    try {
      const std::vector<double> first = shard.OpenDataset("contact_first").Read();
      const hdf5::Shape rows = shard.OpenDataset("contact_distance").shape();
      if (first.size() != 1 || rows.size() != 1 ||
          shard.OpenDataset("contact_body").shape() != hdf5::Shape{rows[0], 2} ||
          shard.OpenDataset("contact_point").shape() != hdf5::Shape{rows[0], 3} ||
          shard.OpenDataset("contact_normal").shape() != hdf5::Shape{rows[0], 3})
        throw hdf5::Error("its contacts have arrays of several lengths");
      return {first[0] == first[0], rows[0]};
    } catch (const hdf5::Error& error) {
      throw files::StoreError(
          fmt::format("{}: is damaged: {}; nothing was merged: remove it and its run is done again",
                      path.string(), error.what()));
    }
  }

  /// Rows of contacts in grid order; a run that fills two cells has them twice.
  void PlaceContacts(std::size_t cells) {
    if (!facts_.contacts) return;
    contact_first_.assign(cells, std::numeric_limits<double>::quiet_NaN());
    std::vector<std::uint64_t> rows(cells, 0);
    std::vector<bool> recorded(cells, false);
    for (const Cells& run : runs_) {
      const auto path = places_.Find(run.run_id);
      if (!path && base_)
        for (const std::size_t cell : run.cells)
          if (const auto there = base_->ContactRows(cell)) {
            recorded[cell] = true;
            rows[cell] = there->count;
          }
      if (!path) continue;
      const hdf5::File shard = OpenOf(run.run_id, *path, files::ReadSealed(*path));
      const ShardContacts contacts = ContactsOf(shard, *path);
      for (const std::size_t cell : run.cells) {
        recorded[cell] = contacts.are_recorded;
        rows[cell] = contacts.rows;
      }
    }
    for (std::size_t cell = 0; cell < cells; ++cell) {
      if (recorded[cell]) contact_first_[cell] = static_cast<double>(contact_rows_);
      contact_rows_ += rows[cell];
    }
  }

  store::FileExtents extents() const {
    return {store::kSchemaVersion, layout_.grid, facts_.cycles};
  }

  /// Returns the number of shards.
  std::size_t CopyShards(hdf5::File& file) {
    std::vector<hdf5::Dataset> series, contacts;
    for (const store::Array* array : series_) series.push_back(file.OpenDataset(array->name));
    if (facts_.contacts)
      for (const char* name : kContactArrays) contacts.push_back(file.OpenDataset(name));
    std::size_t merged = 0;
    for (const Cells& run : runs_) {
      const auto path = places_.Find(run.run_id);
      if (!path && base_ && base_->Has(run.cells.front())) {
        CopyFromBase(run, series, contacts);
        file.CheckWritten();
        ++merged;
      }
      if (!path) continue;
      try {
        CopyShard(run, *path, series, contacts);
      } catch (const hdf5::Error& error) {
        throw files::StoreError(
            fmt::format("{}: is damaged: {}; nothing was merged: remove it and its run is done "
                        "again",
                        path->string(), error.what()));
      }
      file.CheckWritten();
      ++merged;
    }
    return merged;
  }

  /// Copies the run from the base.
  void CopyFromBase(const Cells& run, std::vector<hdf5::Dataset>& series,
                    std::vector<hdf5::Dataset>& contacts) {
    for (const std::size_t cell : run.cells) {
      for (std::size_t i = 0; i < series.size(); ++i) CopyCell(*series_[i], cell, series[i]);
      for (std::size_t i = 0; i < numbers_.size(); ++i) numbers_[i][cell] = base_->Number(i, cell);
      for (std::size_t i = 0; i < texts_.size(); ++i) texts_[i][cell] = base_->Text(i, cell);
      for (std::size_t i = 0; i < contacts.size(); ++i)
        CopyRows(kContactArrays[i], cell, contacts[i]);
    }
    run_provenance_.Add(run.run_id, base_->ProvenanceOf(run.run_id));
  }

  /// Copies values, so that the filters of the base do not matter.
  void CopyCell(const store::Array& array, std::size_t cell, hdf5::Dataset& target) {
    if (!base_->file().Has(array.name)) return;  // an earlier build did not record it
    const hdf5::Dataset source = base_->file().OpenDataset(array.name);
    if (source.type() != array.type || source.shape() != array.shape)
      throw hdf5::Error(fmt::format("{} of the file has another shape", array.name));
    const hdf5::Shape place = Unflatten(layout_.grid, cell);
    const bool is_cut_alike = source.ChunkShape() == array.chunk;
    hdf5::RawChunk stored;
    for (std::uint64_t i = 0; i < store::ChunksOfCell(array, place.size()); ++i) {
      hdf5::Shape start = store::ChunkStart(array, place, i), count = array.chunk;
      for (std::size_t k = 0; k < count.size(); ++k)
        count[k] = std::min(count[k], array.shape[k] - start[k]);
      if (is_cut_alike && !source.ReadChunk(start, stored)) continue;  // no cycle in this chunk ran
      CopyBlock(array.name.c_str(), source, start, start, count, target);
    }
  }

  void CopyRows(const char* name, std::size_t cell, hdf5::Dataset& target) {
    const auto rows = base_->ContactRows(cell);
    if (!rows || rows->count == 0) return;
    const hdf5::Dataset source = base_->file().OpenDataset(name);
    hdf5::Shape from(source.shape().size(), 0), count = source.shape();
    hdf5::Shape to = from;
    from[0] = rows->first;
    to[0] = static_cast<std::uint64_t>(contact_first_[cell]);
    count[0] = rows->count;
    CopyBlock(name, source, from, to, count, target);
  }

  void CopyBlock(const char* name, const hdf5::Dataset& source, const hdf5::Shape& from,
                 const hdf5::Shape& to, const hdf5::Shape& count, hdf5::Dataset& target) {
    const std::vector<double> values = source.Read(from, count);
    target.Write(to, count, values);
    copied_rows_.push_back({name, to, count, files::Checksum(std::as_bytes(std::span(values)))});
  }

  void CopyShard(const Cells& run, const fs::path& path, std::vector<hdf5::Dataset>& series,
                 std::vector<hdf5::Dataset>& contacts) {
    const std::vector<std::byte> bytes = files::ReadSealed(path);
    const auto index = FindIndex(bytes);
    if (index && IsUsable(*index)) {
      CheckIsOf(run.run_id, path, index->info.plan_sha256, index->info.run_id);
      return CopyIndexed(*index, bytes, run, series);
    }
    CopyFile(run, path, OpenOf(run.run_id, path, bytes), series, contacts);
  }

  bool IsUsable(const ShardIndex& index) const {
    const auto is_known = [this](const IndexedChunk& chunk) {
      return chunk.series < series_.size() &&
             chunk.chunk < store::ChunksOfCell(*series_[chunk.series], layout_.grid.size());
    };
    return index.layout == layout_checksum_ && index.numbers.size() == numbers_.size() &&
           index.texts.size() == texts_.size() && std::ranges::all_of(index.chunks, is_known);
  }

  void CopyFile(const Cells& run, const fs::path& path, const hdf5::File& shard,
                std::vector<hdf5::Dataset>& series, std::vector<hdf5::Dataset>& contacts) {
    const Source source = {shard, store::ReadVersion(shard, path.string())};
    try {
      for (std::size_t i = 0; i < series.size(); ++i) CopySeries(source, run.cells, i, series[i]);
      ReadRunArrays(source, run);
      for (std::size_t i = 0; i < contacts.size(); ++i)
        CopyContacts(kContactArrays[i], shard.OpenDataset(kContactArrays[i]), run.cells,
                     contacts[i]);
    } catch (const std::out_of_range&) {
      throw files::StoreError(
          fmt::format("{}: lacks the values of its run; nothing was merged: remove "
                      "it and its run is done again",
                      path.string()));
    }
  }

  /// The same by the index of a shard, without HDF5.
  void CopyIndexed(const ShardIndex& index, std::span<const std::byte> bytes, const Cells& run,
                   std::vector<hdf5::Dataset>& series) {
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      store::CheckValues(facts_.numbers[i].name, std::span(&index.numbers[i], 1), extents());
    for (const IndexedChunk& chunk : index.chunks)
      CopyChunk(chunk.series, chunk.chunk, chunk.filter_mask,
                bytes.subspan(chunk.begin, chunk.bytes), run.cells, series[chunk.series]);
    for (const std::size_t cell : run.cells) {
      for (std::size_t i = 0; i < numbers_.size(); ++i) numbers_[i][cell] = index.numbers[i];
      for (std::size_t i = 0; i < texts_.size(); ++i) texts_[i][cell] = index.texts[i];
    }
    run_provenance_.Add(run.run_id, index.provenance);
  }

  void CopyChunk(std::uint32_t series, std::uint32_t chunk, std::uint32_t filter_mask,
                 std::span<const std::byte> bytes, const std::vector<std::size_t>& cells,
                 hdf5::Dataset& target) {
    const std::uint64_t checksum = files::Checksum(bytes);
    for (const std::size_t cell : cells) {
      target.WriteChunk(store::ChunkStart(*series_[series], Unflatten(layout_.grid, cell), chunk),
                        filter_mask, bytes);
      copied_.push_back({series, chunk, cell, checksum});
    }
  }

  void CopySeries(const Source& shard, const std::vector<std::size_t>& cells, std::size_t index,
                  hdf5::Dataset& target) {
    const store::Array& array = *series_[index];
    const auto found = shard.Open(array.name);
    if (!found) return;
    const hdf5::Dataset& source = *found;
    hdf5::Shape shape = array.shape;
    std::fill_n(shape.begin(), layout_.grid.size(), 1);
    // The chunk shape of an array follows from plan and schema version; reading it is slow.
    const bool is_cut_alike = is_cut_known_[index] || source.ChunkShape() == array.chunk;
    is_cut_known_[index] = true;
    if (source.type() != array.type || source.shape() != shape || !is_cut_alike)
      throw hdf5::Error(fmt::format("{} of a shard has another shape", array.name));
    const bool has_checksums = source.HasChecksums();
    const hdf5::Shape origin(layout_.grid.size(), 0);
    const std::uint64_t chunks = store::ChunksOfCell(array, origin.size());
    hdf5::RawChunk chunk;
    for (std::uint32_t i = 0; i < chunks; ++i) {
      if (!source.ReadChunk(store::ChunkStart(array, origin, i), chunk))
        continue;  // no cycle in this chunk ran
      // Shards of earlier versions have chunks without checksums.
      const std::uint32_t mask = chunk.filter_mask | (has_checksums ? 0 : hdf5::kNoChecksum);
      CopyChunk(static_cast<std::uint32_t>(index), i, mask, chunk.bytes, cells, target);
    }
  }

  void ReadRunArrays(const Source& shard, const Cells& run) {
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      const auto dataset = shard.Open(facts_.numbers[i].name);
      if (!dataset) continue;
      const double value = dataset->Read().at(0);
      for (const std::size_t cell : run.cells) numbers_[i][cell] = value;
    }
    for (std::size_t i = 0; i < texts_.size(); ++i) {
      const auto dataset = shard.Open(facts_.texts[i].name);
      if (!dataset) continue;
      const std::string text = dataset->ReadText().at(0);
      for (const std::size_t cell : run.cells) texts_[i][cell] = text;
    }
    run_provenance_.Add(run.run_id, shard.file.OpenGroup("provenance").Texts());
  }

  void CopyContacts(const char* name, const hdf5::Dataset& source,
                    const std::vector<std::size_t>& cells, hdf5::Dataset& target) {
    const std::vector<double> values = source.Read();
    if (values.empty()) return;
    const std::uint64_t checksum = files::Checksum(std::as_bytes(std::span(values)));
    for (const std::size_t cell : cells) {
      hdf5::Shape start(source.shape().size(), 0);
      start[0] = static_cast<std::uint64_t>(contact_first_[cell]);
      target.Write(start, source.shape(), values);
      copied_rows_.push_back({name, std::move(start), source.shape(), checksum});
    }
  }

  void WriteProvenance(hdf5::File& file) const {
    hdf5::Group group = run_provenance_.Write(file, provenance_);
    const auto write = [&](const char* name, const std::string& text, const char* doc) {
      hdf5::Dataset dataset = group.CreateDataset({name, hdf5::Type::kText, {}, {}, 0});
      dataset.WriteText({{text}});
      dataset.SetText("long_name", doc);
    };
    write("plan_text", plan_.whole ? plan_.whole->short_text : yaml::ToYaml(plan_),
          "the plan, as YAML");
    write("scenario_text", plan_.scenario_text, "the scenario and the files that it uses");
  }

  const plan::Plan& plan_;
  const store::Provenance& provenance_;
  const ShardPlaces places_;
  const store::PlanFacts facts_;
  std::optional<MergeBase> base_;
  std::vector<Cells> runs_;  ///< each id once, in grid order
  store::Layout layout_;
  std::uint64_t layout_checksum_ = 0;
  std::vector<const store::Array*> series_;
  std::vector<bool> is_cut_known_;  ///< in the order of series_
  std::vector<CopiedChunk> copied_;
  std::vector<CopiedRows> copied_rows_;
  std::vector<std::vector<double>> numbers_;     ///< in the order of facts_.numbers
  std::vector<std::vector<std::string>> texts_;  ///< in the order of facts_.texts
  std::vector<double> contact_first_;
  std::uint64_t contact_rows_ = 0;
  store::MergedProvenance run_provenance_;
};

}  // namespace

void Merge(const plan::Plan& plan, const store::Provenance& provenance, const fs::path& folder,
           const fs::path& out) {
  Merge(plan, provenance, std::vector{folder}, out);
}

void Merge(const plan::Plan& plan, const store::Provenance& provenance,
           const std::vector<fs::path>& shards, const fs::path& out, const fs::path& base) {
  std::error_code not_there;
  for (const fs::path& place : shards)
    if (!fs::is_regular_file(place, not_there)) files::RequireFolder(place, "shards");
  files::RequireFolder(out.has_parent_path() ? out.parent_path() : ".", "the result");
  std::error_code ignored;
  if (fs::is_directory(out, ignored))
    throw files::StoreError(
        fmt::format("{}: is a folder where the result should go; the shards were left "
                    "as they are: choose another name (-o)",
                    out.string()));
  files::RemoveStaleTemporariesBeside(out);
  files::TemporaryFile temporary(out);
  try {
    Merger merger(plan, provenance, shards, base);
    merger.Write(temporary.path());
    merger.Verify(temporary.path());
    merger.Prove(temporary.path());
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: cannot merge the shards: {}; they are all kept in {}: make "
                    "room or mend it, and merge again",
                    out.string(), error.what(), shards.empty() ? "" : shards.front().string()));
  }
  files::AppendSeal(temporary.path(), out);
  temporary.Publish();
}

}  // namespace cdb::shards
