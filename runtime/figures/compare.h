// Compares two results files of one benchmark: speed, accuracy and stability (`cdb compare`).
// Numbers only; printers/compare.h prints them.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/model.h"
#include "runtime/figures/points.h"
#include "runtime/protocol/series.h"
#include "runtime/results/store.h"

namespace cdb::figures {

// What a comparison can find, and which of it fails a build: --fail-if, --allow and --fail-above.

enum class Finding {
  kSlower,
  kMemory,
  kStability,  ///< verdicts
  kAccuracy,   ///< errors, missed pairs and contacts
  kPairs,      ///< other pairs of the same detector and motion, not compared with exact ones
  kPhysics,    ///< another last state, or repeats with different ones
  kMissing,    ///< a benchmark or a point
  kScenes,     ///< other scenes; not compared unless allowed
  kUnsure,     ///< times whose noise is too large, or that were not compared
};
inline constexpr std::size_t kFindingCount = 9;

struct FindingInfo {
  Finding finding;
  std::string_view word;  ///< of --fail-if
  std::string_view text;  ///< of the result: `slower`
  bool fails;             ///< by default
  bool has_limit;         ///< fails only above a limit of --fail-above
};
std::span<const FindingInfo, kFindingCount> Findings();
const FindingInfo& InfoOf(Finding finding);

/// Which findings fail, and above which limits.
class Gate {
 public:
  explicit Gate(double limit = 0.05);

  bool Fails(Finding finding) const { return fails_[Index(finding)]; }
  double LimitOf(Finding finding) const { return limits_[Index(finding)]; }
  void SetFails(Finding finding, bool fails) { fails_[Index(finding)] = fails; }
  void SetLimit(Finding finding, double limit) { limits_[Index(finding)] = limit; }
  /// `slower by more than 5 %`, `other physics`.
  std::string TextOf(Finding finding) const;

 private:
  static std::size_t Index(Finding finding) { return static_cast<std::size_t>(finding); }
  std::array<bool, kFindingCount> fails_;
  std::array<double, kFindingCount> limits_;
};

/// What was found, of one kind.
struct Found {
  Finding finding;
  std::vector<std::string> what;  ///< `sap step`, `heap memory`, `quantity 10`
};

/// A results file in a comparison, with the data that is read from it once.
struct ComparedFile {
  /// `name`: for the output; differs from those of the other files. `selections`: `axis=value`, as
  /// for SelectPart, but an axis may be named several times, and one that the file lacks is
  /// ignored. Throws StoreError, also if the file has none of the values selected on an axis.
  ComparedFile(const std::filesystem::path& path, std::string name,
               const std::vector<std::string>& selections = {});
  ComparedFile(const ComparedFile&) = delete;
  ComparedFile& operator=(const ComparedFile&) = delete;

  /// Whether every run is on a trace.
  bool IsOnTraces() const;
  /// Whether its times are numbers of instructions.
  bool CountsInstructions() const;

  const std::string name;
  const results::ResultFile file;
  const std::optional<plan::Plan> plan;  ///< nullopt for a plan of another version of cdb
  const Model model;
};

/// A point that both files have.
struct MatchedPoint {
  Point a, b;                      ///< the point in each file
  std::vector<std::string> place;  ///< its value on each axis of PointMatch
  std::string PlaceText(const std::vector<std::string>& axes) const;
};

struct PointMatch {
  std::vector<std::string> axes;            ///< the axes by which points are matched
  std::vector<bool> is_text;                ///< for each of the axes
  std::optional<std::size_t> group;         ///< the axis of detectors, else the first axis of texts
  std::vector<MatchedPoint> points;         ///< in the grid order of a
  std::vector<std::string> only_a, only_b;  ///< points without a match, for the output
  std::vector<std::string> notes;           ///< about axes that are ignored
};
/// Matches points by the names and values of axes. An axis with one value that only one file has,
/// or whose one value differs between the files, is ignored, with a note. Throws StoreError for an
/// axis with several values that only one file has, and if no point is left.
PointMatch MatchPoints(const ComparedFile& a, const ComparedFile& b);

/// A fact that differs, with its value in each file; `-` if it has none.
struct SetupDifference {
  std::string name;
  std::string a, b;
};

struct SetupComparison {
  /// Equal builds on one machine differ by less, even if its load or clock changed in between.
  static constexpr double kDrift = 0.5;

  std::vector<SetupDifference> machine;     ///< machine, build and versions
  std::vector<SetupDifference> scenes;      ///< parameters that make another scene
  std::vector<SetupDifference> parameters;  ///< other parameters of the runs, and plug-ins
  std::vector<std::string> notes;           ///< warnings about builds and occasions, in sentences
  bool is_interleaved = false;              ///< the runs of both files are interleaved in time
  /// The reason why a change of times may be one of the machine: `the runs were not interleaved`.
  std::string doubt = {};

  /// The limit above which a slower time is certain.
  double LimitOfTimes(double limit) const {
    return doubt.empty() || limit > kDrift ? limit : kDrift;
  }
};
/// Compares the provenance of two files, and the scenes of their matched points.
SetupComparison CompareSetups(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match);

/// Whether the motion is the same to the last bit; for detectors on traces, whether they report the
/// same pairs in the last cycle.
struct StateComparison {
  bool of_pairs = false;  ///< compares pairs: every run is on a trace
  std::size_t same = 0;
  std::vector<std::size_t> other;      ///< matched points with different final states
  std::vector<std::size_t> unsettled;  ///< points whose repeats differ within one file: not
                                       ///< repeatable
  std::size_t unknown = 0;             ///< points with a run without a final state: it failed
};

enum class Direction { kBetter, kWorse, kOther };

/// A value that differs at a matched point. For verdicts, numbers are NaN.
struct FactChange {
  std::size_t point;
  Direction direction;
  double a = kNone, b = kNone;
  std::string text_a, text_b;  ///< with units
  /// The relative change of the values; infinite from 0, or if one is missing.
  double RelativeChange() const;
};

/// One fact over all points.
struct FactComparison {
  enum class Kind {
    kVerdict,
    kError,  ///< of /accuracy
    kPairs,  ///< missed pairs and contacts
    kCount,  ///< neither better nor worse: pairs, contacts
    kMemory,
  };
  Kind kind;
  std::string name;                 ///< `energy error`
  std::size_t points = 0;           ///< number compared
  std::vector<FactChange> changes;  ///< the largest first

  std::size_t Count(Direction direction) const;
  /// True if something is worse: a verdict or a count of misses at all, other values by more than
  /// `margin`.
  bool IsWorse(double margin) const;
};

StateComparison CompareStates(const ComparedFile& a, const ComparedFile& b,
                              const PointMatch& match);
/// Facts that both files have, verdicts first.
std::vector<FactComparison> CompareFacts(const ComparedFile& a, const ComparedFile& b,
                                         const PointMatch& match);

/// A test and its verdict.
struct JudgedChange {
  TestedChange tested;
  double adjusted_p = kNone;
  ChangeVerdict verdict = ChangeVerdict::kCannotTell;
  /// True if it is slower, and the whole interval is above `margin`.
  bool IsSlowerThan(double margin) const {
    return verdict == ChangeVerdict::kSlower && tested.interval.low > 1 + margin;
  }
};

/// The times of one phase, at a point or of a group.
struct TimeChange {
  protocol::Phase phase;
  double a_ns, b_ns;  ///< or instructions; for a group, geometric means over its points
  Change change;
  JudgedChange absolute;
  /// Relative to the median of all groups in this phase, which follows changes of the machine or of
  /// common code; the ratio is NaN if there are fewer than kLeastGroups groups.
  JudgedChange relative;
};

struct TimedPoint {
  std::size_t point;  ///< index in the match
  std::vector<TimeChange> phases;
};

/// Points with the same detector, or the same value on the axis PointMatch::group.
struct TimedGroup {
  std::string name;
  std::size_t points = 0;
  std::vector<TimeChange> phases;
};

struct TimeComparison {
  /// The median of fewer groups would follow a single group that changed.
  static constexpr std::size_t kLeastGroups = 3;

  bool has_intervals = false;        ///< both files have enough repeats, or count instructions
  bool counts_instructions = false;  ///< the times are numbers of instructions
  std::vector<TimedPoint> points;
  std::vector<TimedGroup> groups;
  /// The median of all groups in `common_phase`.
  std::optional<TestedChange> common;
  protocol::Phase common_phase = protocol::Phase::kStep;
  /// cdb's own overhead per cycle, which does not depend on the detector.
  std::optional<TestedChange> harness;
  /// Points whose times are not compared, with the reason.
  std::vector<std::pair<std::size_t, std::string>> left_out;

  /// True if all groups changed together.
  bool HasCommonShift() const { return common && common->p <= kSignificance; }
};

/// `phase`: only that phase; all by default. The changes are not judged yet.
TimeComparison CompareTimes(const ComparedFile& a, const ComparedFile& b, const PointMatch& match,
                            std::optional<protocol::Phase> phase);

/// Judges groups by Holm and points by Benjamini and Hochberg, corrected for all tests of
/// `comparisons` together. `margin`: as for JudgeChange.
void JudgeTimes(const std::vector<TimeComparison*>& comparisons, double margin);

struct CompareOptions {
  std::vector<std::string> select = {};       ///< `axis=value`
  std::optional<protocol::Phase> phase = {};  ///< only this phase
  /// What fails. Times that differ by less than its limit are the same.
  Gate gate = Gate();
  /// Groups are judged relative to the median of all groups.
  bool is_relative = false;
  bool lists_all = false;  ///< list every point, also those that did not change
};

/// File `b` relative to file `a`, both of which must outlive it.
struct FileComparison {
  const ComparedFile *a, *b;
  PointMatch match;
  SetupComparison setup;
  StateComparison states;
  std::vector<FactComparison> facts;
  TimeComparison times;

  /// Whether the pairs of both files were compared with exact ones.
  bool HasExactPairs() const;
  /// Whether the files have different detectors or narrow phases at matched points.
  bool HasOtherDetectors() const;
  /// Matched points at which the same motion has other pairs: in the last cycle of a trace, or
  /// their number.
  std::vector<std::size_t> OtherPairs() const;
};
/// The two files cannot be compared, because they have other scenes or points.
struct UnlikeScenes : files::StoreError {
  explicit UnlikeScenes(const std::string& why, std::vector<SetupDifference> differences_of = {})
      : StoreError(why), differences(std::move(differences_of)) {}
  std::vector<SetupDifference> differences;  ///< of the scenes
};
/// Throws UnlikeScenes, also for unlike scenes unless the gate allows them, and StoreError if the
/// options request data that the files lack. The changes are not judged yet.
FileComparison CompareFiles(const ComparedFile& a, const ComparedFile& b,
                            const CompareOptions& options);

/// The judgement that the options select.
const JudgedChange& JudgementOf(const TimeChange& change, const CompareOptions& options);
/// What is worse by more than the limits, or unsure, whether it fails or not.
std::vector<Found> FindingsOf(const FileComparison& comparison, const CompareOptions& options);
bool IsFailed(const FileComparison& comparison, const CompareOptions& options);

struct BenchmarkHistory {
  std::vector<std::unique_ptr<ComparedFile>> files;  ///< two or more
  std::vector<FileComparison> steps;                 ///< each file relative to the one before it
  std::vector<FileComparison> to_first;  ///< the third file and later ones, relative to the first;
                                         ///< empty for two

  /// The last file relative to the first.
  const FileComparison& Whole() const { return to_first.empty() ? steps[0] : to_first.back(); }
};
/// `names`: for the output. Throws StoreError as CompareFiles does, and for a selection that no
/// file has.
BenchmarkHistory MakeHistory(const std::vector<std::filesystem::path>& paths,
                             const std::vector<std::string>& names, const CompareOptions& options);
/// Judges all steps, corrected for the tests of all benchmarks together.
void JudgeHistories(std::vector<BenchmarkHistory>& benchmarks, const CompareOptions& options);

/// A benchmark that was not compared, because its files have other scenes.
struct UnlikeBenchmark {
  std::string name, why;
  std::vector<std::string> files;
  std::vector<SetupDifference> differences;
};

/// All of a command.
struct Comparisons {
  std::vector<std::string> names;  ///< of the files or folders on the command line
  std::vector<BenchmarkHistory> benchmarks;
  std::vector<UnlikeBenchmark> unlike;
  std::vector<std::string> unmatched;  ///< files that are not in all folders
  std::vector<std::string> missing;    ///< those of them that the last folder lacks

  bool IsHistory() const { return names.size() > 2; }
  bool IsFailed(const CompareOptions& options) const;
};

}  // namespace cdb::figures
