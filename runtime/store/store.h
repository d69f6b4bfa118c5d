// Results on disk: one shard for each run, merged into one file, which `cdb doc results` describes.
// Does not know how runs are executed; no other folder knows HDF5.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "dsl/check.h"
#include "runtime/measure/noise.h"
#include "runtime/measure/run_scalars.h"
#include "runtime/measure/samples.h"
#include "runtime/measure/series.h"
#include "runtime/measure/verdict.h"

namespace cdb::store {

/// The world refused: the message names the file, the cause, what was kept and the remedy. Exit
/// status 2.
class StoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The system cannot read a file now, or prove that it is whole: this says nothing of the file. No
/// StoreError, so that nobody takes it for damage.
class CannotRead : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// `flag_values` of `status`, in this order.
enum class Status : std::int8_t { kMissing, kDone, kSkipped, kFailed, kCrashed, kTimedOut };
inline constexpr std::string_view kStatusNames[] = {"missing", "done",    "skipped",
                                                    "failed",  "crashed", "timed_out"};
/// `done`, `timed_out`.
constexpr std::string_view StatusName(Status status) {
  const auto index = static_cast<std::size_t>(status);
  CDB_CHECK(index < std::size(kStatusNames));
  return kStatusNames[index];
}

/// How a run stands: its process, and its physics.
struct Outcome {
  Status status = Status::kMissing;
  measure::Verdict verdict = measure::Verdict::kUnknown;
  /// Done, and its timings are of the scene.
  bool IsGood() const { return status == Status::kDone && !measure::HasVoidTimings(verdict); }
};

/// All that one run left behind. `series` point into memory of the caller.
struct RunResult {
  Status status = Status::kMissing;
  measure::Judgement judgement;
  std::uint64_t n_cycles = 0;
  double started_s = 0;  ///< since 1970-01-01 00:00:00 UTC
  std::string state_hash;
  std::string host;
  std::string message;    ///< why it did not end well; empty where it did
  std::string omitted;    ///< names of the components left out, separated by spaces
  std::string decisions;  ///< about each component: a line each (compiler/plan/pruning.h)
  std::string models;     ///< the hulls of the compounds in the scene: a line each; may be empty
  double load = 0;        ///< the machine's one-minute load average when the run began
  measure::RunScalars scalars;
  measure::NoiseJudgement noise;
  std::vector<std::pair<const measure::Series*, std::span<const std::byte>>> series;
  measure::RunErrors errors;  ///< empty where the scene asks for none
  std::vector<measure::ContactRecord>
      contacts;  ///< of all cycles in order; as many a cycle as the series `contacts` says

  Outcome outcome() const { return {status, judgement.verdict}; }
};

/// Facts of build and machine for `/provenance`, by name: `cdb_version`, `bullet_version`,
/// `compiler`, `cpu`, `build_type`…
using Provenance = std::map<std::string, std::string>;

/// Writes one shard for each run of a plan. What follows from the plan alone is worked out once, in
/// the constructor: where there are many runs it takes longer than writing one. Holds references to
/// plan and provenance. Threads: Write may be called by several at once, for different runs.
class ShardWriter {
 public:
  ShardWriter(const plan::Plan& plan, const Provenance& provenance);
  ~ShardWriter();

  /// Writes `folder/<run id>.h5`: under a temporary name, closed, fsynced, renamed, and the folder
  /// fsynced; when it returns the run is safe. Throws StoreError; then no file of the final name
  /// was made or changed.
  void Write(const plan::Run& run, const RunResult& result,
             const std::filesystem::path& folder) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

/// `ShardWriter(plan, provenance).Write(run, result, folder)`: for one run.
void WriteShard(const plan::Plan& plan, const plan::Run& run, const RunResult& result,
                const Provenance& provenance, const std::filesystem::path& folder);

/// Removes temporaries in `folder` that processes of this host left behind when they were killed.
/// Those that somebody still writes are locked and stay (temporary_file.h), and so do those of
/// other hosts. Throws StoreError where there is no folder.
void RemoveStaleTemporaries(const std::filesystem::path& folder);

struct ShardInfo {
  std::string run_id;
  std::string plan_sha256;
  Outcome outcome;
  std::string omitted, decisions;  ///< as in RunResult
};
/// Throws StoreError for what is not a whole shard (truncated, not HDF5, another schema version).
ShardInfo ReadShardInfo(const std::filesystem::path& file);

/// Makes `out` from `shards`, folders of them or single files (of a run that stands twice, the
/// first): under a temporary name, verified against the shards, fsynced, renamed. Runs without a
/// shard are as in `base`, a results file of the same plan that may be `out`, where that is given,
/// else cells with status `missing`. The shards are left alone. Throws StoreError; then `out` is as
/// before.
void Merge(const plan::Plan& plan, const Provenance& provenance,
           const std::vector<std::filesystem::path>& shards, const std::filesystem::path& out,
           const std::filesystem::path& base = {});
void Merge(const plan::Plan& plan, const Provenance& provenance,
           const std::filesystem::path& folder, const std::filesystem::path& out);

/// Every run of the plan, and every reference, has a file of its name in `shards`, which are as
/// Merge takes them.
bool HasAllShards(const plan::Plan& plan, const std::vector<std::filesystem::path>& shards);
/// What others write there can be seen at once; false where that is not known, as on NFS.
bool IsOnLocalDisk(const std::filesystem::path& path);

/// How much of a file is read, in a process with limits of time and memory, before it is used;
/// beside its digest and its structure.
enum class ProofOf {
  kStructure,  ///< no values
  kFewValues,  ///< all, in files of at most 64 MiB
  kEveryValue,
};

/// What helps against a damaged results file.
inline constexpr std::string_view kResultRemedy =
    "merge it again from its shards, restore a copy, or run it again with --fresh";

/// The file is HDF5, or ends as the files of cdb do.
bool IsStored(const std::filesystem::path& file);
/// Its attribute `schema`: `cdb-results`, `cdb-trace`; empty where it has none. Throws StoreError.
std::string ReadSchema(const std::filesystem::path& file);

/// A results file or a shard opened for reading. Not for several threads.
class ResultFile {
 public:
  /// Throws StoreError where it is not as it was written, or cannot be read.
  explicit ResultFile(const std::filesystem::path& file, ProofOf of = ProofOf::kFewValues);
  ResultFile(ResultFile&&) noexcept;
  ~ResultFile();

  /// False for files of versions of cdb that wrote none.
  bool has_digest() const;
  /// It holds one run, and is to be merged.
  bool is_shard() const;
  const std::string& plan_sha256() const;
  const std::string& title() const;
  const std::string& benchmark() const;
  const std::string& source() const;  ///< the scenario file, as it was named
  /// Keeps the values of `axis` at the places `kept`, in their order, for all that follows: axes
  /// and cells are of these alone. `kept` is not empty.
  void Select(std::size_t axis, const std::vector<std::size_t>& kept);
  /// Where a point of the whole file stands after Select; nullopt where it was not kept.
  std::optional<std::vector<std::size_t>> SelectedPoint(const std::vector<std::size_t>& at) const;
  /// The axes of the sweep, without rep, phase and cycle.
  const std::vector<plan::Axis>& axes() const;
  std::uint64_t repeats() const;
  /// The number of repeats up to the last one that any point has, at least 1: `cdb run --until` may
  /// stop before all are done.
  std::uint64_t begun_repeats() const;
  std::uint64_t cycles() const;
  /// `dataset`, here and below: a variable of the root, `accuracy/NAME`, or a fact of a run by its
  /// name in /run. The names are the same for files of every schema version.
  bool Has(std::string_view dataset) const;

  /// A cell: the index on each axis, and the repeat.
  struct Cell {
    std::vector<std::size_t> at;
    std::uint64_t rep = 0;
  };
  Status ReadStatus(const Cell& cell) const;
  std::uint64_t ReadCycleCount(const Cell& cell) const;
  measure::Judgement ReadJudgement(const Cell& cell) const;
  std::string ReadText(std::string_view dataset,
                       const Cell& cell) const;  ///< `state_hash`, `message`, `omitted`
  double ReadReal(std::string_view dataset,
                  const Cell& cell) const;  ///< `peak_rss`, `build_time`, …
  /// One scalar series of a cell, the cycles that ran; one phase of `duration`. Integers come as
  /// doubles.
  std::vector<double> ReadSeries(std::string_view dataset, const Cell& cell) const;
  std::vector<double> ReadDuration(measure::Phase phase, const Cell& cell) const;
  /// One series of /accuracy (schema::ErrorInfo::series) of a cell, at each sample.
  std::vector<double> ReadSamples(std::string_view dataset, const Cell& cell) const;
  /// One cycle of a series with several values in each (`poses`, `boxes`), last dimension fastest.
  /// The cycle must have run.
  std::vector<double> ReadCycle(std::string_view dataset, const Cell& cell,
                                std::uint64_t cycle) const;
  /// `count` contacts from the cell's own number `first` on; the series `contacts` says how many
  /// each cycle has.
  std::vector<measure::ContactRecord> ReadContacts(const Cell& cell, std::uint64_t first,
                                                   std::uint64_t count) const;
  /// Why reference runs are of no use, a line each: `reference 0123…: crashed: …`. Empty where all
  /// ended well, or there are none.
  std::vector<std::string> ReadReferenceTroubles() const;
  /// `/provenance`: `plan_text`, `scenario_text`, and its attributes.
  std::string ReadProvenance(std::string_view name) const;
  /// An attribute of the run in a cell; where runs do not differ in it, that of all.
  std::string ReadProvenance(std::string_view name, const Cell& cell) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cdb::store
