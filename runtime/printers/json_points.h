// The parts of a results document (results_document.h). Throws StoreError.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "runtime/figures/model.h"
#include "runtime/figures/ratios.h"
#include "runtime/printers/document.h"

namespace cdb::printers {

// The parts of a results document (results_document.h). Throws StoreError.

/// Keys stay in the order in which they are written.
using Json = nlohmann::ordered_json;

/// `value` to `digits` significant digits; null if it is not finite.
Json JsonNumber(double value, int digits = 6);
Json JsonNumbers(const std::vector<double>& values, int digits = 6);

/// `of(i)` for each i below `count`.
template <typename Of>
Json JsonColumn(std::size_t count, Of of) {
  Json column = Json::array();
  for (std::size_t i = 0; i < count; ++i) column.push_back(of(i));
  return column;
}

/// Replaces every array below `columns` whose values are all equal by `{"constant": value}`.
Json FoldColumns(Json columns);

/// The sections as a terminal shows them.
Json SectionsJson(const Document& document);

/// The largest number of points for which a document has all statistics of all phases.
inline constexpr std::size_t kMaxWholePoints = 5000;
/// More points: the document has only the figures that a page can hold, with fewer digits.
bool IsLarge(const figures::Model& model);
Json ModelNumber(const figures::Model& model, double value);
/// Null if no cycle is bad.
Json CycleOrNull(const figures::Ending& ending);

// The parts of the file that are in the document. Times have these statistics beside the mean.
inline constexpr std::pair<const char*, figures::CycleStatistic> kDocumentedStatistics[] = {
    {"median", figures::CycleStatistic::kMedian},
    {"p5", figures::CycleStatistic::kP5},
    {"p95", figures::CycleStatistic::kP95},
    {"min", figures::CycleStatistic::kMin},
    {"max", figures::CycleStatistic::kMax}};
std::vector<protocol::Phase> DocumentedPhases(const figures::Model& model);
std::vector<std::string> DocumentedCounts(const figures::Model& model);  ///< series
std::vector<std::string> DocumentedMemory(const figures::Model& model);

/// `{"quantity": 100}`: the values on the axes `axes`, at the point `at` on them.
Json PlaceJson(const figures::Model& model, const std::vector<std::size_t>& axes,
               const figures::Point& at);

/// An axis in the head of a table or figure: its title, a known label or its name.
std::string LabelOf(const plan::Axis& axis);
/// `axes`.
Json DocumentAxes(const figures::Model& model);
/// `phases`: their names and contents.
Json DocumentPhases();
/// `points`: columns of equal length. For more than kMaxWholePoints points: step and detect only,
/// with mean and interval, and constant columns as `{"constant": value}`.
Json DocumentPoints(const figures::Model& model);
/// `ratios`; null if no detectors are compared.
Json DocumentRatios(const figures::Model& model, const figures::Comparison* comparison);
/// `fronts`: for each error, one for each scene.
Json DocumentFronts(const figures::Model& model);

// For the page.
/// `pooled`: for each set of axes that can be pooled, the pooled rows, and the ratios and verdicts
/// at each place on the other axes. Sets that would make the document too large are left out.
Json DocumentPooled(const figures::Model& model, const figures::Comparison* comparison);
/// `cycles`: the time of each cycle (median over the repeats), averaged in at most 200 bins, for at
/// most 60 points; if there are more, the first ones of each detector. Null without timings, and
/// for more than kMaxWholePoints points.
Json DocumentCycles(const figures::Model& model);
/// `distributions`: quantiles over the cycles, and the mean of each repeat. All phases for at most
/// 500 points, step and detect for at most 2000; null for more, and without timings.
Json DocumentDistributions(const figures::Model& model);

/// `boundaries` of the searches, pooled over the seeds; null without a search.
Json DocumentBoundaries(const figures::Model& model);
/// `races`: how each configuration did; null without a race.
Json DocumentRaces(const figures::Model& model);
/// `steady`: where the step is steady; null for runs that are too short to tell.
Json DocumentSteady(const figures::Model& model);
/// `runs`: the number of runs by their ending.
Json DocumentRuns(const figures::Model& model);
/// `warnings` to read before quoting a figure: each with its kind and a sentence, the most severe
/// first.
Json DocumentWarnings(const figures::Model& model);
/// `omissions`: for each component that was omitted at some point, the points and the reason.
Json DocumentOmissions(const figures::Model& model);
/// `findings`: the faults that the pair referee found, by detector.
Json DocumentFindings(const figures::Model& model);
/// Of narrow phases: see ContactFindings.
Json DocumentContacts(const figures::Model& model);
/// `failures`: at most `most` of them.
Json DocumentFailures(const figures::Model& model, std::size_t most);
/// `noise`.
Json DocumentNoise(const figures::Model& model);
// `machine`, `build` and `provenance`: facts by name. Facts that the file lacks are left out.
Json DocumentMachine(const results::ResultFile& file);
Json DocumentBuild(const results::ResultFile& file);
Json DocumentProvenance(const results::ResultFile& file);

}  // namespace cdb::printers
