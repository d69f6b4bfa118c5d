#include "runtime/report/show.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <string_view>

#include "runtime/report/cells.h"
#include "runtime/report/figures.h"
#include "runtime/report/findings.h"
#include "runtime/report/show_detectors.h"
#include "runtime/report/show_head.h"
#include "runtime/report/show_ratios.h"
#include "runtime/report/table.h"

namespace cdb::report {
namespace {

/// The axes that make the rows of each table.
std::vector<std::vector<std::size_t>> ChooseTables(const store::ResultFile& file,
                                                   const std::vector<std::size_t>& asked) {
  if (!asked.empty()) return {asked};
  std::vector<std::size_t> all(file.axes().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::size_t rows = 1;
  for (const plan::Axis& axis : file.axes()) rows *= axis.values.size();
  if (rows <= kMaxRows) return {all};
  std::vector<std::vector<std::size_t>> tables;
  for (const std::size_t axis : all) tables.push_back({axis});
  return tables;
}

/// That of the median step.
TimeUnit UnitOf(const std::map<Point, Pool>& pools) {
  std::vector<double> steps;
  for (const auto& [key, pool] : pools)
    steps.push_back(Percentile(pool.phases[measure::IndexOf(measure::Phase::kStep)], 0.5));
  std::ranges::sort(steps);
  return TimeUnit::For(Percentile(steps, 0.5));
}

/// Medians, and the 5th and 95th percentile: a row for each point on the axes `by`.
class PhaseTables {
 public:
  PhaseTables(const store::ResultFile& file, const std::vector<std::size_t>& by)
      : file_(file), by_(by), has_times_(file.Has("duration")) {}

  std::string Text(const std::map<Point, Pool>& pools) {
    if (has_times_) unit_ = UnitOf(pools);
    AddColumns();
    for (const auto& [key, pool] : pools) AddRows(key, pool);
    if (has_times_)
      return fmt::format("\nMedian of a cycle, {}\n{}", unit_.name, medians_.Text()) +
             fmt::format("\n5th .. 95th percentile, {}\n{}", unit_.name, spread_.Text());
    return file_.Has("pairs") ? fmt::format("\nMedian of a cycle\n{}", medians_.Text())
                              : std::string();
  }

 private:
  void AddColumns() {
    for (Table* table : {&medians_, &spread_}) {
      for (const std::size_t axis : by_)
        table->AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
      if (!has_times_) continue;
      for (const std::string_view phase : measure::PhaseNames())
        table->AddColumn(std::string(phase), true);
    }
    if (file_.Has("pairs")) medians_.AddColumn("pairs", true);
    if (file_.Has("contacts")) medians_.AddColumn("contacts", true);
  }

  void AddRows(const Point& key, const Pool& pool) {
    std::vector<std::string> middle;
    for (std::size_t i = 0; i < by_.size(); ++i)
      middle.push_back(CoordinateText(file_.axes()[by_[i]], key[i]));
    std::vector<std::string> ends = middle;
    if (has_times_) {
      for (const auto& phase : pool.phases) {
        const auto number = [&](double p) { return ShortNumber(Percentile(phase, p) / unit_.ns); };
        middle.push_back(number(0.5));
        ends.push_back(number(0.05) + " .. " + number(0.95));
      }
    }
    if (file_.Has("pairs")) middle.push_back(ShortNumber(Percentile(pool.pairs, 0.5)));
    if (file_.Has("contacts")) middle.push_back(ShortNumber(Percentile(pool.contacts, 0.5)));
    medians_.AddRow(std::move(middle));
    spread_.AddRow(std::move(ends));
  }

  const store::ResultFile& file_;
  const std::vector<std::size_t>& by_;
  const bool has_times_;
  TimeUnit unit_ = TimeUnit::For(0);
  Table medians_, spread_;
};

}  // namespace

ShowText Show(const store::ResultFile& file, const ShowOptions& options) {
  const CellGroups groups = GroupCells(file);
  const std::vector<std::string> references = file.ReadReferenceTroubles();
  const std::vector<DetectorFindings> findings = FindingsOf(file);
  std::vector<std::size_t> asked;
  for (const std::string& name : options.by) asked.push_back(FindAxis(file, name));
  std::string text = SummaryHead(file, groups, findings, references);
  if (!groups.good.empty())
    for (const auto& by : ChooseTables(file, asked))
      text += PhaseTables(file, by).Text(PoolCells(file, groups.good, by));
  text += ShowDetectors(file, groups.good, asked) + ShowRatios(file, groups.good) +
          OtherFaults(findings);
  return {text, groups.bad.size() + references.size()};
}

}  // namespace cdb::report
