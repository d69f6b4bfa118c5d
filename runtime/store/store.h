// What a run leaves behind, and results files, which `cdb doc results` describes. Knows nothing of
// how runs are executed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "dsl/text/check.h"
#include "runtime/machine/noise.h"
#include "runtime/measure/run_scalars.h"
#include "runtime/measure/samples.h"
#include "runtime/measure/series.h"
#include "runtime/measure/verdict.h"
#include "runtime/store/files/errors.h"

namespace cdb::store {

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
  std::string decisions;  ///< about each component: a line each (compiler/analysis/pruning.h)
  std::string models;     ///< the hulls of the compounds in the scene: a line each; may be empty
  double load = 0;        ///< the machine's one-minute load average when the run began
  measure::RunScalars scalars;
  machine::NoiseJudgement noise;
  std::vector<std::pair<const measure::Series*, std::span<const std::byte>>> series;
  measure::RunErrors errors;  ///< empty where the scene asks for none
  std::vector<measure::ContactRecord>
      contacts;  ///< of all cycles in order; as many a cycle as the series `contacts` says

  Outcome outcome() const { return {status, judgement.verdict}; }
};

/// Facts of build and machine for `/provenance`, by name: `cdb_version`, `bullet_version`,
/// `compiler`, `cpu`, `build_type`…
using Provenance = std::map<std::string, std::string>;

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
