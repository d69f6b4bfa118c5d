#include "runtime/report/show.h"

#include <numeric>

#include "runtime/report/show_detectors.h"
#include "runtime/report/show_head.h"
#include "runtime/report/show_phases.h"
#include "runtime/report/show_plots.h"
#include "runtime/report/show_ratios.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/figures.h"
#include "runtime/statistics/findings.h"
#include "runtime/statistics/points.h"

namespace cdb::report {
namespace {

/// The axes that make the rows of each table.
std::vector<std::vector<std::size_t>> ChooseTables(const store::ResultFile& file,
                                                   std::size_t point_count,
                                                   const std::vector<std::size_t>& asked) {
  if (!asked.empty()) return {asked};
  std::vector<std::size_t> all(file.axes().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  if (point_count <= kMaxRows) return {all};
  std::vector<std::vector<std::size_t>> tables;
  for (const std::size_t axis : all) tables.push_back({axis});
  return tables;
}

}  // namespace

ShowText Show(const store::ResultFile& file, const ShowOptions& options) {
  const statistics::CellGroups groups = statistics::GroupCells(file);
  const std::vector<std::string> references = file.ReadReferenceTroubles();
  const std::vector<statistics::DetectorFindings> findings = statistics::FindingsOf(file);
  std::vector<std::size_t> asked;
  for (const std::string& name : options.by) asked.push_back(statistics::FindAxis(file, name));
  const auto baseline = FindBaseline(file, options.baseline);
  const std::vector<statistics::MeasuredPoint> points =
      statistics::MeasuredPoints(file, options.only_sound);
  statistics::CycleTimes times(file, options.statistic);
  std::string text = SummaryHead(
      file, {groups, findings, references, options.only_sound, HarnessText(file, points, times)});
  for (const auto& by : ChooseTables(file, points.size(), asked))
    text += ShowPhases(file, points, by, options.phases, times);
  text += ShowDetectors(file, points, asked, times) +
          ShowRatios(file, points, baseline, options.phases, times) +
          statistics::OtherFaults(findings);
  if (options.plots) text += ShowPlots(file, points, options.phases, times);
  return {text, groups.bad.size() + references.size()};
}

}  // namespace cdb::report
