// The result of a run, and results files, which `cdb doc results` describes. Independent of how
// runs are executed.
#pragma once

#include <cstddef>
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
#include "compiler/schema/series.h"
#include "dsl/text/check.h"
#include "runtime/protocol/machine/noise.h"
#include "runtime/protocol/samples.h"
#include "runtime/protocol/series.h"
#include "runtime/protocol/verdict.h"
#include "runtime/results/files/errors.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/hdf5/object.h"

namespace cdb::results {

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

/// The state of a run: its process, and its physics.
struct Outcome {
  Status status = Status::kMissing;
  protocol::Verdict verdict = protocol::Verdict::kUnknown;
  /// True if it is done and its timings are not void.
  bool IsGood() const { return status == Status::kDone && !protocol::HasVoidTimings(verdict); }
};

/// All results of one run. `series` point into memory of the caller.
struct RunResult {
  Status status = Status::kMissing;
  protocol::Judgement judgement;
  std::uint64_t n_cycles = 0;
  double started_s = 0;  ///< since 1970-01-01 00:00:00 UTC
  std::string state_hash;
  std::string host;
  std::string message;    ///< reason why it failed, or the first pair that its detector missed
  std::string omitted;    ///< names of the omitted components, separated by spaces
  std::string decisions;  ///< the decision about each component, one per line
                          ///< (compiler/analysis/pruning.h)
  std::string models;     ///< the hulls of the compounds in the scene, one per line; may be empty
  double load = 0;        ///< the machine's one-minute load average when the run began
  schema::RunScalars scalars;
  machine::NoiseJudgement noise;
  std::vector<std::pair<const protocol::Series*, std::span<const std::byte>>> series;
  protocol::RunErrors errors;  ///< empty if the scene requests none
  std::vector<protocol::ContactRecord>
      contacts;  ///< of all cycles in order; the series `contacts` has their number in each cycle

  Outcome outcome() const { return {status, judgement.verdict}; }
};

/// Facts about build and machine for `/provenance`, by name: `cdb_version`, `bullet_version`,
/// `compiler`, `cpu`, `build_type`…
using Provenance = std::map<std::string, std::string>;

/// How much of a file, in addition to its digest and its structure, is read in a process with
/// limits of time and memory before it is used.
enum class ProofOf {
  kStructure,  ///< no values
  kFewValues,  ///< all, in files of at most 64 MiB
  kEveryValue,
};

/// The remedy for a damaged results file.
inline constexpr std::string_view kResultRemedy =
    "merge it again from its journal, restore a copy, or run it again with --fresh";

/// True if the file is HDF5, or ends as files of cdb do.
bool IsStored(const std::filesystem::path& file);
/// Its attribute `schema`: `cdb-results`, `cdb-trace`; empty if it has none. Throws StoreError.
std::string ReadSchema(const std::filesystem::path& file);

/// A reference run that failed, or whose motion is not sound.
struct ReferenceTrouble {
  std::string id;
  std::string text;  ///< `reference 0123…: crashed: …`, or `drifting from 0.35 s on, 3 objects`
  bool is_unsound;
};

/// A results file opened for reading. Not thread-safe.
class ResultFile {
 public:
  /// Throws StoreError if it is not as it was written, or cannot be read.
  explicit ResultFile(const std::filesystem::path& file, ProofOf of = ProofOf::kFewValues);
  ResultFile(ResultFile&&) noexcept;
  ~ResultFile();

  /// False for files of versions of cdb that wrote no digest.
  bool has_digest() const;
  /// Throws StoreError if the file is not as results of its plan are. The constructor has checked
  /// it with a plan that lists its runs; for one in the short form, call it before Select.
  void CheckIsOf(const plan::Plan& plan) const;
  const std::string& plan_sha256() const;
  const std::string& title() const;
  const std::string& benchmark() const;
  /// That a step, or the steps of a frame, may take, if the scenario sets it.
  std::optional<double> budget_ns() const;
  /// The simulated time of these steps, s; nullopt if the budget is for one step.
  std::optional<double> frame_s() const;
  /// `require` of the scenario, without the budget.
  const std::vector<plan::Requirement>& requirements() const;
  const std::string& source() const;  ///< the scenario file, as the user named it
  /// Restricts `axis` to the values with the indices `kept`, in that order, for all later calls:
  /// axes and cells are those of the selection. `kept` is not empty.
  void Select(std::size_t axis, const std::vector<std::size_t>& kept);
  /// The point after Select that corresponds to a point of the complete file; nullopt if it was not
  /// kept.
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
  /// From now on, `Has` is false for everything that was measured by the clock of the runs:
  /// durations, and the times of queries, of placing and of building. For files that count
  /// instructions, which are no times.
  void LeaveOutClock();
  /// Whether `poses` are of the origins of meshes and the axes of their files. In files of cdb
  /// before that, they are of the centres of mass and the principal axes.
  bool HasPosesOfOrigins() const;

  /// A cell: the index on each axis, and the repeat.
  struct Cell {
    std::vector<std::size_t> at;
    std::uint64_t rep = 0;
  };
  Status ReadStatus(const Cell& cell) const;
  std::uint64_t ReadCycleCount(const Cell& cell) const;
  protocol::Judgement ReadJudgement(const Cell& cell) const;
  std::string ReadText(std::string_view dataset,
                       const Cell& cell) const;  ///< `state_hash`, `message`, `omitted`
  double ReadReal(std::string_view dataset,
                  const Cell& cell) const;  ///< `peak_rss`, `build_time`, …
  /// One scalar series of a cell, over the cycles that ran; one phase of `duration`. Integers are
  /// returned as doubles.
  std::vector<double> ReadSeries(std::string_view dataset, const Cell& cell) const;
  std::vector<double> ReadDuration(protocol::Phase phase, const Cell& cell) const;
  /// A series with a value for each type of query, of one type, in each cycle.
  std::vector<double> ReadOfQueries(std::string_view dataset, schema::QueryType type,
                                    const Cell& cell) const;
  /// The counts of an event in a phase, in each cycle.
  std::vector<double> ReadCounter(schema::Counter counter, protocol::Phase phase,
                                  const Cell& cell) const;
  /// One series of /accuracy (schema::ErrorInfo::series) of a cell, at each sample.
  std::vector<double> ReadSamples(std::string_view dataset, const Cell& cell) const;
  /// One cycle of a series with several values in each (`poses`, `boxes`), with the last dimension
  /// fastest. The cycle must have run.
  std::vector<double> ReadCycle(std::string_view dataset, const Cell& cell,
                                std::uint64_t cycle) const;
  /// `count` contacts of the cell from its number `first` on; the series `contacts` has the number
  /// of contacts in each cycle.
  std::vector<protocol::ContactRecord> ReadContacts(const Cell& cell, std::uint64_t first,
                                                    std::uint64_t count) const;
  /// Reference runs that failed or are not sound. Empty if there are none.
  std::vector<ReferenceTrouble> ReadReferenceTroubles() const;
  /// `/provenance`: `plan_text`, `scenario_text`, and its attributes.
  std::string ReadProvenance(std::string_view name) const;
  /// An attribute of the run in a cell, or the common attribute if runs do not differ in it.
  std::string ReadProvenance(std::string_view name, const Cell& cell) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The answers to the requirements of a file, for each point of its grid and each requirement, the
/// requirement fastest (figures/requirements.h).
struct StoredAnswers {
  std::vector<double> answer, value, low, high;
  /// What its searches found, for each point of the grid without the axis of the search
  /// (figures/searches/searches.h).
  struct Boundaries {
    std::vector<double> outcome, value, low, high, changes, probes;
  };
  Boundaries boundaries = {};
  /// How each configuration did in its race, for each point of the grid
  /// (figures/races/races.h).
  struct Races {
    std::vector<double> outcome, repeats, against, ratio, low, high;
  };
  Races races = {};
  /// True if no search or race needs another run: the others are then left out for good.
  bool has_all_runs = false;
};

// The dimensions of a results file, with their coordinates.

/// A dimension with its coordinate, a dataset of the same name.
struct Dimension {
  std::string name;  ///< including its group: `run/quantity`
  std::uint64_t size = 0;
  hdf5::Type type = hdf5::Type::kInt32;
  std::vector<double> numbers;     ///< the coordinate: `size` numbers,
  std::vector<std::string> texts;  ///< or texts; neither: a dimension without a coordinate
  std::map<std::string, std::string> attributes;
  std::string units_by_label;  ///< separated by spaces, if the labels differ in unit
};

/// netCDF's mark for a dimension without a coordinate, from its file format specification; its size
/// follows.
inline constexpr std::string_view kNoCoordinate =
    "This is a netCDF dimension but not a netCDF variable.";
/// The numbers from 0 to `n` - 1.
std::vector<double> Indices(std::uint64_t n);
/// A dimension of indices. `doc`: its `long_name`.
Dimension Counted(std::string name, std::uint64_t size, std::string doc);
/// A dimension of words. Readers that cannot read text datasets (Octave) find them in the attribute
/// `labels`, which is left out if one word contains every separator.
Dimension Labelled(std::string name, std::vector<std::string> texts, std::string doc);
/// The unit of a number without one, by the netCDF Climate and Forecast conventions.
inline constexpr const char* kNoUnit = "1";
/// Of an axis of sampled points: the names of what varies, which are arrays in /sampled, whose
/// `scale` is `linear` or kLogScale, with the ends of their ranges.
inline constexpr const char *kSampledAttribute = "sampled", *kLogScale = "log",
                            *kFirstAttribute = "first", *kLastAttribute = "last";
/// Of an axis with a race: its figure, and its tolerance.
inline constexpr const char *kRaceAttribute = "race_by", *kToleranceAttribute = "race_tolerance";
/// Of an axis with a search: its condition as it is written, and as what it is judged.
inline constexpr const char *kUntilAttribute = "until", *kFigureAttribute = "until_figure",
                            *kComparisonAttribute = "until_comparison",
                            *kLimitAttribute = "until_limit", *kScaleAttribute = "scale";
/// The values of an axis. `is_integer`: the result of Axis::IsInteger, which checks all values.
Dimension AxisDimension(const plan::Axis& axis, bool is_integer);

// `/provenance` of a merged file: facts about build and machine. A fact that is the same in every
// run is an attribute; others are arrays over `run`, the ids of the runs.

/// The dimension of the arrays in the group.
inline constexpr std::string_view kProvenanceRuns = "run";

class MergedProvenance {
 public:
  /// The facts of one run, by name.
  void Add(const std::string& run_id, const std::map<std::string, std::string>& facts);
  /// Creates the group. `of_merging`: facts of this process, used if no run has them.
  hdf5::Group Write(hdf5::File& file, const Provenance& of_merging) const;

 private:
  /// The distinct texts of one fact, and the index of each run's text.
  struct Fact {
    std::vector<std::string> texts = {""};  ///< the first is for runs without the fact
    std::vector<std::size_t> by_run;        ///< in the order of ids_; runs at the end may be
                                            ///< missing
    std::map<std::string, std::size_t> places = {{"", 0}};
  };

  std::vector<std::string> TextsOf(const Fact& fact) const;

  std::vector<std::string> ids_;
  std::map<std::string, Fact> facts_;
};

// Poses in an HDF5 file made by the user: datasets `position` (n x 3, m; from MATLAB transposed, as
// it stores its arrays), of any integers or floats, and optionally
// `orientation` (n x 4, quaternions w, x, y, z, or as its attribute `order` says: `xyzw`),
// `linear_velocity` (n x 3, m/s) and `angular_velocity` (n x 3, rad/s), and for a path `time` (n,
// s), each in the root of the file.

/// The rows of all objects, one after the other; empty if the file has no such dataset.
struct PoseArrays {
  std::vector<double> time, position, orientation, linear_velocity, angular_velocity;
};

/// Nullopt if it is a results file. Throws StoreError, which names the dataset, for other shapes
/// and types, and if there is none. `has_times`: reads `time`, too.
std::optional<PoseArrays> ReadPoseArrays(const std::filesystem::path& file, bool has_times = false);
/// Columns of arrays anywhere in the file: `/log/x`, `/robot/position[:,2]`, `/poses[0,:,4,1]`.
/// Throws StoreError, which names the column.
std::vector<std::vector<double>> ReadColumns(const std::filesystem::path& file,
                                             const std::vector<std::string>& written);
/// The arrays in a file, with their shapes, for messages; empty if it cannot be read.
std::string ArraysIn(const std::filesystem::path& file);

}  // namespace cdb::results
