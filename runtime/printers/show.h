// A results file as tables (`cdb show`).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/conclusions.h"
#include "runtime/figures/errors.h"
#include "runtime/figures/model.h"
#include "runtime/figures/requirements.h"
#include "runtime/figures/times.h"
#include "runtime/printers/document.h"
#include "runtime/results/store.h"

namespace cdb::printers {

struct ShowOptions {
  /// Axes that make the rows; everything else is pooled. Empty: all axes together if that is at
  /// most kMaxRows rows, else each axis separately.
  std::vector<std::string> by = {};
  /// The detector by which the others are divided. Empty: the first that has all cells.
  std::string baseline = {};
  /// Leave out runs whose timings are voided by their verdict.
  bool only_sound = false;
  /// The phases of the tables. Empty: all; ratios of detect and step.
  std::vector<protocol::Phase> phases = {};
  figures::CycleStatistic statistic = figures::CycleStatistic::kMean;
  /// Add plots of characters: times over the cycles, and over axes of numbers.
  bool plots = false;
  Format format = Format::kTerminal;
  /// Only the first conclusions (figures/conclusions.h), what limits their trust, and one table.
  bool is_brief = false;
};

inline constexpr std::size_t kMaxRows = 60;

/// In this order: detectors that missed pairs; omissions, as far as they change the figures; the
/// mean of every phase, pairs and contacts, with spread and interval (figures/times.h); the cost of
/// detectors, and the ratio between them. Void runs are in separate rows, marked, and in no mean or
/// ratio with others. Throws StoreError, also for an axis or a detector that the file does not
/// have.
Printed Show(const results::ResultFile& file, const ShowOptions& options = {});

/// The last lines below a brief summary: the commands that show more. `name`: of the file.
std::string MoreText(const results::ResultFile& file, const std::string& name);

struct ShowErrorOptions {
  figures::ErrorOptions errors;
  bool only_sound = false;
  Format format = Format::kTerminal;
};
/// Error against run time (`cdb show --error`): each configuration, the fastest first, with its
/// speed relative to real time, the time of a simulated second (the statistic of figures/times.h
/// over the time step), its error, and whether it is on the Pareto front, that is, no other is both
/// faster and as accurate. A configuration that is worse than those of the front only within the
/// intervals ties with it. Intervals of times are over repeats; those of errors are over seeds, if
/// the file sweeps them. Void configurations are last, marked and not on the front; those without
/// the error or without a time are listed separately. Throws StoreError, also for an error or an
/// axis that the file does not have.
Printed ShowError(const results::ResultFile& file, const ShowErrorOptions& options);

struct ShowTableOptions {
  /// A phase, `ms_per_s` (the run time of a simulated second), a series, a memory or an error.
  std::string metric;
  std::vector<std::string> by = {};  ///< axes of the rows; empty: all others, without seeds
  /// The axis across. Empty: that of the detectors, else the last one with several values.
  std::string columns = {};
  std::string baseline = {};  ///< a value of `columns`; empty: no speed-up
  bool only_sound = false;
  figures::CycleStatistic statistic = figures::CycleStatistic::kMean;
  Format format = Format::kTerminal;
};
/// One table for a paper (`cdb show --table`): the rows are points of the axes `by`, the columns
/// values of one axis, the cells a figure with its interval (MeasuredText). Seeds, and axes that
/// make neither, are pooled. With a baseline, more columns have its time over that of each other
/// value, paired by repeat. Cells that are void, not sound or below the floor of an error are
/// marked by `*` and named below. Throws StoreError, also for a figure, axis or value that the file
/// does not have.
Printed ShowTable(const results::ResultFile& file, const ShowTableOptions& options);

/// The sentences on the method, as one paragraph (`cdb show --method`). Throws StoreError.
Printed ShowMethod(const results::ResultFile& file, Format format);

/// `146.2 [145.1, 147.9]`: as many digits as the interval justifies, that is one or two of half its
/// width, but between two and six of the value; without an interval as ShortNumber.
std::string MeasuredText(double value, const figures::Interval& interval);

struct ShowBudgetOptions {
  figures::Budget budget = {};
  protocol::Phase phase = protocol::Phase::kStep;
  bool only_sound = false;
  Format format = Format::kTerminal;
};
/// The cycles of each point that take longer than a budget (`cdb show --budget`): their number, the
/// 99th percentile of the times of the cycles (figures/times.h) with its interval, and the longest
/// cycle of any repeat. A point fits if the interval is within the budget. Throws StoreError.
Printed ShowBudget(const results::ResultFile& file, const ShowBudgetOptions& options);

/// The part of one benchmark: the verdicts along its graded axis, the last one of numbers, in a
/// line for each combination of the other axes, with equal neighbours joined: `single  stable 1 ..
/// 5 | penetrating 10 | collapsed 20 .. 1000` The worst verdict of the repeats counts. Throws
/// StoreError.
std::string StabilityMap(const results::ResultFile& file);

struct VerifyText {
  std::string text;
  /// Every run succeeded, and no detector misses a pair or a contact. Contacts that Bullet misses
  /// do not count: it makes those that no detector makes.
  bool is_good = false;
};

/// A row for the broad phase of each detector, then one for each narrow phase: first the faulty
/// ones, otherwise in the file's order. Below: the first bad cycle of each, the command that
/// replays it, and `left_out`. The file holds runs with `record pairs`. Throws
/// StoreError.
VerifyText VerifyTable(const results::ResultFile& file, const std::vector<std::string>& left_out);

// The sections of a summary (show.h). All throw StoreError.

/// The runs, and how far their figures can be trusted.
Section SummaryHead(const figures::Model& model, bool has_padding);
/// The runs and the first conclusions; and the reasons why they may not be trusted, without those
/// that hold for most files.
Section BriefHead(const figures::Model& model);
Section BriefDoubts(const figures::Model& model);

/// Which points stay within `budget`; the statistic of `model` is kP99. `has_answer`: also in
/// a sentence.
Section BudgetSection(const figures::Model& model, const figures::Budget& budget,
                      protocol::Phase phase, bool has_answer);

/// The requirements of the scenario, each with its answer, and the first points that fail; none
/// without `require`.
void AddRequirements(const figures::Model& model, Document& document);
/// The boundaries that the searches of the scenario found; none without a search.
void AddBoundaries(const figures::Model& model, Document& document);
/// The conclusions of a file, that on its races first.
std::vector<figures::Conclusion> ConclusionsOf(const figures::Model& model);
/// The races of the scenario: how each configuration did; none without a race.
void AddRaces(const figures::Model& model, Document& document);
/// The boundaries with the title of the file, for a terminal.
std::string BoundariesText(const results::ResultFile& file);
/// What the same searches found in two files, by place; no rows if they have none in common.
Section BoundaryChanges(const results::ResultFile& a, const results::ResultFile& b);
/// A test case for each requirement and point, as JUnit XML: failed if it is not met, skipped if
/// that cannot be told (`cdb show --junit`). Throws StoreError.
Printed JunitText(const results::ResultFile& file);

/// Detectors that missed pairs, and those that are known to miss some and were not checked.
std::vector<std::string> WrongDetectors(const figures::Model& model);

/// Up to three tables with a row for each value on the axes `by`: the time of every phase, or of
/// those in `phases` if that is not empty, and the means of pairs and contacts; the 5th and 95th
/// percentile over the cycles; and the intervals of the means. None for a file without timings and
/// pairs.
void AddPhases(const figures::Model& model, const std::vector<std::size_t>& by,
               const std::vector<protocol::Phase>& phases, Document& document);

/// A table of narrow phases that ran on the pairs of a trace, if there are any: time per pair,
/// pairs that were not handled, and contacts against exact ones. A row for each value on the axes
/// `by`.
void AddPairs(const figures::Model& model, const std::vector<std::size_t>& by, Document& document);

/// A table of the processor's and the system's events in each of `phases` (all if it is empty), or
/// a note if no machine counted any. A row for each value on the axes `by`. None for a file without
/// counters.
void AddCounters(const figures::Model& model, const std::vector<std::size_t>& by,
                 const std::vector<protocol::Phase>& phases, Document& document);

/// A table for each type of queries, if there are any: counts, hits and times in a cycle, and
/// errors against exact answers. A row for each value on the axes `by`.
void AddQueries(const figures::Model& model, const std::vector<std::size_t>& by,
                Document& document);

/// Sums over the configurations that runs checked.
struct ConfigurationFigures {
  std::size_t all = 0, hit = 0;
  bool are_told_apart = false;  ///< the next two are known
  std::size_t self = 0, scene = 0;
  std::size_t compared = 0;           ///< with exact geometry, which was certain
  std::size_t missed = 0, wrong = 0;  ///< of these: hits not found, and hits where there is none
  double distance_error = figures::kNone;  ///< m: the largest
};
ConfigurationFigures ConfigurationFiguresOf(const figures::Model& model,
                                            const std::vector<const figures::MeasuredPoint*>& of);
/// From the time of one.
double ConfigurationsPerSecond(double step_ns);
/// A table of them; none for a file without any.
void AddConfigurations(const figures::Model& model, const std::vector<std::size_t>& by,
                       Document& document);

/// Two tables for each of `phases` (detect if that is empty), if the file compares detectors: mean
/// and worst cycle, pairs, faults and
/// memory of each detector, in the order of their axis, at each point of the other axes, or of `by`
/// if that is not empty; axes that make no rows are pooled. If one axis with at least three numbers
/// changes the number of objects: p of time ~ objects^p, by least squares over the logarithms of
/// means. Last, other faults of detectors than missed pairs.
void AddDetectors(const figures::Model& model, const std::vector<std::size_t>& by,
                  const std::vector<protocol::Phase>& phases, Document& document);
void AddOtherFaults(const figures::Model& model, Document& document);

/// Times of `phases` (detect and step if that is empty) over those of the baseline (by default the
/// first detector that has all cells), at each point of the other axes, with the interval of each
/// ratio, paired by repeat. The geometric mean is over the points that all detectors have, sound
/// and with the same omissions; ratios of other points are in parentheses.
void AddRatios(const figures::Model& model, const std::string& baseline,
               const std::vector<protocol::Phase>& phases, Document& document);

/// The phases (only the step if `phases` is empty) over the cycles, a line for each of at most 24
/// points; and over each axis of at least three numbers. None for a file without timings.
void AddPlots(const figures::Model& model, const std::vector<protocol::Phase>& phases,
              Document& document);

/// Bars from the least to the greatest of `values`, which are averaged in at most `width` bins; a
/// space for a bin without values. Values within a fraction `alike` of the least are drawn at one
/// height.
std::string Sparkline(const std::vector<double>& values, std::size_t width, double alike = 0);

/// A table with a row for each of `rows`: their axes, the number of pooled cells if some row pools
/// several, figures, and the mark.
class RowTable {
 public:
  RowTable(const results::ResultFile& file, const figures::Rows& rows);
  /// A column of figures.
  void AddColumn(std::string_view head) { table_.AddColumn(head, true); }
  /// A figure for each column. `note` precedes the row's mark.
  void AddRow(const figures::Row& row, const std::vector<std::string>& figures,
              const std::string& note = "");
  Table Take();

 private:
  const results::ResultFile& file_;
  const figures::Rows& rows_;
  Table table_;
  bool has_notes_ = false;
};

/// Adds a column for each of the axes, which identify the rows.
void AddAxes(const results::ResultFile& file, const std::vector<std::size_t>& axes, Table& table);
/// The first columns of a row: its coordinates.
std::vector<std::string> Coordinates(const results::ResultFile& file,
                                     const std::vector<std::size_t>& axes,
                                     const figures::Point& at);

}  // namespace cdb::printers
