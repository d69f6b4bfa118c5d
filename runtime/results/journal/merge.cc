// Merges finished runs into one file without decoding values: chunks are copied as stored,
// filtered.
#include "runtime/results/journal/merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/results/examine.h"
#include "runtime/results/files/limited_process.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/hdf5/filters.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/journal/merge_base.h"
#include "runtime/results/journal/run_writer.h"
#include "runtime/results/layout.h"
#include "runtime/results/store.h"
#include "runtime/results/versions.h"

namespace cdb::journal {
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

std::size_t FlatIndex(const hdf5::Shape& grid, const std::vector<std::size_t>& at,
                      std::uint64_t rep) {
  std::size_t index = 0;
  for (std::size_t i = 0; i < at.size(); ++i) index = index * grid[i] + at[i];
  return index * grid.back() + rep;
}

class Merger {
 public:
  /// `base`: empty, or the file with the runs that no journal holds. `answers`: null if the
  /// requirements were not judged.
  Merger(const plan::Plan& plan, const results::Provenance& provenance,
         const std::vector<fs::path>& places, const fs::path& base,
         const results::StoredAnswers* answers)
      : plan_(plan), provenance_(provenance), journals_(places), facts_(plan), answers_(answers) {
    journals_.RequirePlan(plan, facts_.sha256);
    if (!base.empty()) base_.emplace(base, facts_);
    hdf5::Shape grid;
    for (const plan::Axis& axis : plan.axes) grid.push_back(axis.values.size());
    grid.push_back(plan.repeats);
    FindRuns(grid);
    PlaceContacts(hdf5::Product(grid));
    layout_ = results::MakeLayout(plan, facts_, contact_rows_);
    for (const results::Array& array : layout_.arrays)
      if (array.series != nullptr) series_.push_back(&array);
    for (const results::RunNumber& number : facts_.numbers)
      numbers_.emplace_back(hdf5::Product(grid), number.missing);
    for (const results::RunText& text : facts_.texts) {
      texts_.emplace_back(hdf5::Product(grid));
      if (text.name != "run/run_id") continue;
      for (const Cells& cells : runs_)
        for (const std::size_t cell : cells.cells) texts_.back()[cell] = cells.run_id;
    }
    plan.ForEachSkipped([&](const std::vector<std::size_t>& point) {
      for (std::uint64_t rep = 0; rep < plan.repeats; ++rep)
        numbers_[0][FlatIndex(grid, point, rep)] = static_cast<double>(results::Status::kSkipped);
    });
  }

  void Write(const fs::path& path) {
    hdf5::File file = hdf5::File::Create(path);
    results::CreateArrays(file, layout_);
    const std::size_t merged = CopyRuns(file);
    const std::size_t left_out = LeaveOut();
    results::WriteHead(file, plan_, facts_,
                       left_out == 0 ? fmt::format("merged {} of {} runs", merged, runs_.size())
                                     : fmt::format("merged {} runs, all that are needed of {}",
                                                   merged, runs_.size()));
    file.SetText(results::kDigestAttribute, results::kDigestText);
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      file.OpenDataset(facts_.numbers[i].name).Write(numbers_[i]);
    for (std::size_t i = 0; i < texts_.size(); ++i)
      file.OpenDataset(facts_.texts[i].name).WriteText(texts_[i]);
    if (!plan_.references.empty())
      MergeReferences(plan_, layout_, journals_, base_ ? &base_->file() : nullptr, file);
    if (facts_.contacts) file.OpenDataset("contact_first").Write(contact_first_);
    results::WriteRequirements(file, plan_.requirements, answers_);
    results::WriteBoundaries(file, plan_, answers_);
    results::WriteRaces(file, plan_, answers_);
    WriteProvenance(file);
    file.Close();
  }

  /// Reads the closed file back and compares it with the data of the runs.
  void Verify(const fs::path& path) {
    const hdf5::File file = hdf5::File::Open(path);
    std::vector<hdf5::Dataset> series;
    for (const results::Array* array : series_) series.push_back(file.OpenDataset(array->name));
    hdf5::RawChunk chunk;
    for (const CopiedChunk& copied : copied_) {
      const results::Array& array = *series_[copied.series];
      const hdf5::Shape cell = results::CellAt(layout_.grid, copied.cell);
      if (!series[copied.series].ReadChunk(results::ChunkStart(array, cell, copied.chunk), chunk) ||
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
      VerifyReferences(plan_, layout_, journals_, base_ ? &base_->file() : nullptr, file);
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
    if (bytes > results::kMostProven) return;
    const std::string why =
        files::RunLimited([&] { results::CheckAllValues(hdf5::File::Open(path), extents()); },
                          files::LimitsForFile(bytes));
    if (!why.empty()) throw hdf5::Error(why);
  }

 private:
  static bool SameBits(double a, double b) { return a == b || (a != a && b != b); }

  void FindRuns(const hdf5::Shape& grid) {
    std::unordered_map<std::string, std::size_t> index;
    plan_.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
      const auto [found, is_new] = index.try_emplace(id, runs_.size());
      if (is_new) runs_.push_back({id, {}});
      runs_[found->second].cells.push_back(FlatIndex(grid, at, rep));
    });
    journals_.RequireRuns([&](const std::string& id) {
      return index.contains(id) ||
             std::ranges::find(plan_.references, id, &plan::Run::id) != plan_.references.end();
    });
  }

  /// Rows of contacts in grid order; a run that fills two cells has them twice.
  void PlaceContacts(std::size_t cells) {
    if (!facts_.contacts) return;
    contact_first_.assign(cells, std::numeric_limits<double>::quiet_NaN());
    std::vector<std::uint64_t> rows(cells, 0);
    std::vector<bool> recorded(cells, false);
    for (const Cells& run : runs_) {
      const auto record = journals_.Find(run.run_id);
      if (!record && base_)
        for (const std::size_t cell : run.cells)
          if (const auto there = base_->ContactRows(cell)) {
            recorded[cell] = true;
            rows[cell] = there->count;
          }
      if (!record) continue;
      const double there = record->Number(kContactRows).value_or(results::kNaN);
      for (const std::size_t cell : run.cells) {
        recorded[cell] = there >= 0;
        rows[cell] = there >= 0 ? static_cast<std::uint64_t>(there) : 0;
      }
    }
    for (std::size_t cell = 0; cell < cells; ++cell) {
      if (recorded[cell]) contact_first_[cell] = static_cast<double>(contact_rows_);
      contact_rows_ += rows[cell];
    }
  }

  results::FileExtents extents() const {
    return {results::kSchemaVersion, layout_.grid, facts_.cycles};
  }

  /// Returns the number of runs that the file has then.
  std::size_t CopyRuns(hdf5::File& file) {
    std::vector<hdf5::Dataset> series, contacts;
    for (const results::Array* array : series_) series.push_back(file.OpenDataset(array->name));
    if (facts_.contacts)
      for (const char* name : kContactArrays) contacts.push_back(file.OpenDataset(name));
    std::size_t merged = 0;
    for (const Cells& run : runs_) {
      if (const auto record = journals_.Find(run.run_id)) {
        try {
          CopyRecord(*record, run, series, contacts);
        } catch (const hdf5::Error& error) {
          throw DamagedRun(journals_.PathOf(run.run_id), run.run_id, error.what());
        }
      } else if (base_ && base_->Has(run.cells.front())) {
        CopyFromBase(run, series, contacts);
      } else {
        continue;
      }
      file.CheckWritten();
      ++merged;
    }
    return merged;
  }

  /// Once its searches or races have ended, marks the runs that they do not need as skipped, and
  /// returns their number.
  std::size_t LeaveOut() {
    if (answers_ == nullptr || !answers_->has_all_runs) return 0;
    std::size_t left_out = 0;
    for (double& status : numbers_[0]) {
      if (status != static_cast<double>(results::Status::kMissing)) continue;
      status = static_cast<double>(results::Status::kSkipped);
      ++left_out;
    }
    return left_out;
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
  void CopyCell(const results::Array& array, std::size_t cell, hdf5::Dataset& target) {
    if (!base_->file().Has(array.name)) return;  // an earlier build did not record it
    const hdf5::Dataset source = base_->file().OpenDataset(array.name);
    if (source.type() != array.type || source.shape() != array.shape)
      throw hdf5::Error(fmt::format("{} of the file has another shape", array.name));
    const hdf5::Shape place = results::CellAt(layout_.grid, cell);
    const bool is_cut_alike = source.ChunkShape() == array.chunk;
    hdf5::RawChunk stored;
    for (std::uint64_t i = 0; i < results::ChunksOfCell(array, place.size()); ++i) {
      hdf5::Shape start = results::ChunkStart(array, place, i), count = array.chunk;
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

  /// Where the arrays and facts of records with the same head go.
  struct Places {
    std::shared_ptr<const About> about;
    std::vector<std::optional<std::uint32_t>> series, contacts;  ///< by array of the head
    std::vector<std::optional<std::size_t>> numbers, texts;      ///< by fact of the head
  };

  /// Records of another version of cdb may lack arrays and facts, or have more; cells without them
  /// keep fill values, and what the file has no place for is left out.
  const Places& PlacesOf(const Record& record) {
    if (places_.about == record.about) return places_;
    places_ = {record.about, {}, {}, {}, {}};
    for (const RecordedArray& array : record.about->arrays) {
      places_.series.push_back(FindSeries(array));
      const auto contact = std::ranges::find(kContactArrays, array.name);
      const bool is_contact = facts_.contacts && contact != std::end(kContactArrays);
      places_.contacts.push_back(
          is_contact ? std::optional(static_cast<std::uint32_t>(contact - kContactArrays))
                     : std::nullopt);
    }
    const auto find = [](const auto& table, const std::string& name) {
      const auto found = std::ranges::find(table, name, [](const auto& fact) { return fact.name; });
      return found == table.end() ? std::nullopt
                                  : std::optional(static_cast<std::size_t>(found - table.begin()));
    };
    for (const std::string& name : record.about->numbers)
      places_.numbers.push_back(find(facts_.numbers, name));
    for (const std::string& name : record.about->texts)
      places_.texts.push_back(find(facts_.texts, name));
    return places_;
  }

  std::optional<std::uint32_t> FindSeries(const RecordedArray& array) const {
    const std::size_t outer = layout_.grid.size();
    for (std::uint32_t i = 0; i < series_.size(); ++i) {
      if (series_[i]->name != array.name) continue;
      const auto is_alike = [outer](const hdf5::Shape& file, const hdf5::Shape& cell) {
        return std::ranges::equal(std::span(file).subspan(outer), cell);
      };
      if (series_[i]->type != array.type || !is_alike(series_[i]->shape, array.shape) ||
          !is_alike(series_[i]->chunk, array.chunk))
        throw hdf5::Error(fmt::format("{} of a finished run has another shape", array.name));
      return i;
    }
    return std::nullopt;
  }

  void CopyRecord(const Record& record, const Cells& run, std::vector<hdf5::Dataset>& series,
                  std::vector<hdf5::Dataset>& contacts) {
    const Places& places = PlacesOf(record);
    for (std::size_t i = 0; i < record.numbers.size(); ++i) {
      const auto place = places.numbers[i];
      if (!place) continue;
      results::CheckValues(facts_.numbers[*place].name, std::span(&record.numbers[i], 1),
                           extents());
      for (const std::size_t cell : run.cells) numbers_[*place][cell] = record.numbers[i];
    }
    for (std::size_t i = 0; i < record.texts.size(); ++i)
      if (const auto place = places.texts[i])
        for (const std::size_t cell : run.cells) texts_[*place][cell] = record.texts[i];
    std::span<const std::byte> left(record.bytes);
    for (const Record::Chunk& chunk : record.chunks) {
      const auto bytes = left.first(chunk.bytes);
      left = left.subspan(chunk.bytes);
      if (const auto place = places.series[chunk.array]) {
        if (chunk.index >= results::ChunksOfCell(*series_[*place], layout_.grid.size()))
          throw hdf5::Error(
              fmt::format("{} of a finished run has too many chunks", series_[*place]->name));
        CopyChunk(*place, chunk.index, bytes, run.cells, series[*place]);
      } else if (const auto contact = places.contacts[chunk.array]) {
        CopyContacts(*contact, bytes, record, run.cells, contacts[*contact]);
      }
    }
    run_provenance_.Add(run.run_id, record.about->provenance);
  }

  void CopyChunk(std::uint32_t series, std::uint32_t chunk, std::span<const std::byte> bytes,
                 const std::vector<std::size_t>& cells, hdf5::Dataset& target) {
    const std::uint64_t checksum = files::Checksum(bytes);
    for (const std::size_t cell : cells) {
      target.WriteChunk(
          results::ChunkStart(*series_[series], results::CellAt(layout_.grid, cell), chunk), 0,
          bytes);
      copied_.push_back({series, chunk, cell, checksum});
    }
  }

  void CopyContacts(std::uint32_t array, std::span<const std::byte> stored, const Record& record,
                    const std::vector<std::size_t>& cells, hdf5::Dataset& target) {
    hdf5::Shape count = target.shape();
    count[0] = static_cast<std::uint64_t>(record.Number(kContactRows).value_or(0));
    const std::size_t item_bytes = hdf5::ItemBytes(target.type());
    const std::vector<std::byte> bytes =
        hdf5::Unfiltered(stored, item_bytes, hdf5::Product(count) * item_bytes);
    for (const std::size_t cell : cells) {
      hdf5::Shape start(count.size(), 0);
      start[0] = static_cast<std::uint64_t>(contact_first_[cell]);
      target.Write(start, count, bytes.data(), count);
      copied_rows_.push_back({kContactArrays[array], std::move(start), count,
                              ChecksumOfDoubles(bytes, target.type())});
    }
  }

  /// Of the values as `Dataset::Read` returns them.
  static std::uint64_t ChecksumOfDoubles(std::span<const std::byte> bytes, hdf5::Type type) {
    if (type == hdf5::Type::kFloat64) return files::Checksum(bytes);
    std::vector<double> values;
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(std::int32_t)) {
      std::int32_t value = 0;
      std::memcpy(&value, &bytes[at], sizeof value);
      values.push_back(value);
    }
    return files::Checksum(std::as_bytes(std::span(values)));
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
  const results::Provenance& provenance_;
  Journals journals_;
  const results::PlanFacts facts_;
  const results::StoredAnswers* answers_;
  std::optional<MergeBase> base_;
  std::vector<Cells> runs_;  ///< each id once, in grid order
  results::Layout layout_;
  std::vector<const results::Array*> series_;
  Places places_;  ///< of the latest record
  std::vector<CopiedChunk> copied_;
  std::vector<CopiedRows> copied_rows_;
  std::vector<std::vector<double>> numbers_;     ///< in the order of facts_.numbers
  std::vector<std::vector<std::string>> texts_;  ///< in the order of facts_.texts
  std::vector<double> contact_first_;
  std::uint64_t contact_rows_ = 0;
  results::MergedProvenance run_provenance_;
};

}  // namespace

void Merge(const plan::Plan& plan, const results::Provenance& provenance, const fs::path& folder,
           const fs::path& out) {
  Merge(plan, provenance, std::vector{folder}, out);
}

void Merge(const plan::Plan& plan, const results::Provenance& provenance,
           const std::vector<fs::path>& places, const fs::path& out, const fs::path& base,
           const JudgeFile& judge) {
  std::error_code not_there;
  for (const fs::path& place : places)
    if (!fs::exists(place, not_there) || fs::is_directory(place, not_there))
      files::RequireFolder(place, "finished runs");
  files::RequireFolder(out.has_parent_path() ? out.parent_path() : ".", "the result");
  std::error_code ignored;
  if (fs::is_directory(out, ignored))
    throw files::StoreError(
        fmt::format("{}: is a folder where the result should go; the finished runs were left as "
                    "they are: choose another name (-o)",
                    out.string()));
  files::RemoveStaleTemporariesBeside(out);
  files::TemporaryFile temporary(out);
  try {
    std::optional<results::StoredAnswers> answers;
    if (judge && (!plan.requirements.empty() || plan.ChoosesRuns())) {
      Merger(plan, provenance, places, base, nullptr).Write(temporary.path());
      files::AppendSeal(temporary.path(), out);
      answers = judge(temporary.path());
    }
    Merger merger(plan, provenance, places, base, answers ? &*answers : nullptr);
    merger.Write(temporary.path());
    merger.Verify(temporary.path());
    merger.Prove(temporary.path());
  } catch (const hdf5::Error& error) {
    throw files::StoreError(
        fmt::format("{}: cannot merge the finished runs: {}; they are all kept in {}: make room or "
                    "mend it, and merge again",
                    out.string(), error.what(), places.empty() ? "" : places.front().string()));
  }
  files::AppendSeal(temporary.path(), out);
  temporary.Publish();
}

}  // namespace cdb::journal
