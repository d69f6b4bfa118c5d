// The cost of each detector in a comparison, and its growth, for `cdb show`.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/detectors.h"
#include "runtime/printers/show.h"
#include "runtime/printers/show_parts.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::DetectorCosts;
using figures::DetectorGrowth;
using figures::Model;

/// The axes that make rows, detectors last so that their rows are adjacent.
std::vector<std::size_t> RowsOf(const Model& model, std::size_t detector_axis,
                                std::vector<std::size_t> by) {
  if (by.empty() && model.points().size() <= kMaxRows) by = figures::AllAxes(model.file());
  std::erase(by, detector_axis);
  by.push_back(detector_axis);
  return by;
}

std::string CountText(double count) {
  return std::isnan(count) ? "-" : fmt::format("{:.0f}", count);
}

std::string ExponentText(double p) {
  // Avoids "-0.00".
  return std::isnan(p) ? "-" : fmt::format("{:.2f}", std::round(100 * p) / 100 + 0.0);
}

/// The unit in which most means are easy to read.
terminal::TimeUnit UnitOf(const std::vector<DetectorCosts>& costs) {
  std::vector<double> means;
  for (const DetectorCosts& row : costs) means.push_back(row.mean.value);
  return terminal::TimeUnit::For(figures::Median(std::move(means)));
}

Section CostsOf(const Model& model, const std::vector<std::size_t>& by) {
  const results::ResultFile& file = model.file();
  const figures::CycleTimes& times = model.times();
  const figures::Rows rows = figures::MatchRows(model.points(), by);
  std::vector<DetectorCosts> costs;
  for (const figures::Row& row : rows.rows) costs.push_back(figures::CostsOf(model, row));
  const terminal::TimeUnit unit = UnitOf(costs);
  const bool has_pairs = file.Has("pairs"), has_exact = file.Has("exact_pairs"),
             has_heap = file.Has("heap");
  RowTable table(file, rows);
  table.AddColumn(times.statistic() == figures::CycleStatistic::kWorst ? "worst of any repeat"
                                                                       : times.StatisticName());
  if (times.HasIntervals()) table.AddColumn(times.IntervalName());
  table.AddColumn("worst");
  if (has_pairs) table.AddColumn("pairs");
  if (has_exact)
    for (const char* head : {"missed", "phantom"}) table.AddColumn(head);
  table.AddColumn("peak rss, MB");
  if (has_heap) table.AddColumn("heap, MB");
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const DetectorCosts& row = costs[i];
    std::vector<std::string> texts = {terminal::ShortNumber(row.mean.value / unit.ns)};
    if (times.HasIntervals())
      texts.push_back(
          figures::IntervalText(times.IntervalOf(figures::Scaled(row.mean, 1 / unit.ns))));
    texts.push_back(terminal::ShortNumber(row.worst / unit.ns));
    if (has_pairs) texts.push_back(terminal::ShortNumber(row.pairs));
    if (has_exact)
      for (const double count : {row.missed, row.phantom}) texts.push_back(CountText(count));
    texts.push_back(terminal::ShortNumber(row.peak_rss / 1e6));
    if (has_heap) texts.push_back(terminal::ShortNumber(row.heap / 1e6));
    table.AddRow(rows.rows[i], texts);
  }
  Section section = {.title = fmt::format("Detectors: a cycle's detect, {}", unit.name),
                     .table = table.Take(),
                     .notes = {times.StatisticAndIntervalNote(rows.pools)}};
  for (std::string& note : rows.MatchNotes()) section.notes.push_back(std::move(note));
  return section;
}

/// The range of the number of objects over which an exponent is fitted: `10 .. 40`.
std::string ObjectsText(const DetectorGrowth::Exponent& exponent) {
  return CountText(exponent.least) + " .. " + CountText(exponent.most);
}

/// Notes to read before the exponents of two rows are compared.
std::vector<std::string> GrowthNotes(const DetectorGrowth& growth) {
  std::vector<std::string> notes;
  if (!growth.is_matched)
    notes.emplace_back("The rows have different numbers of objects: do not compare them.");
  if (growth.dropped > 0)
    notes.push_back(fmt::format("Over the numbers of objects that all rows have, {}.",
                                ObjectsText(growth.exponents.begin()->second)));
  if (!growth.unlike.empty())
    notes.push_back(fmt::format(
        "Some points ran without {} and others with it: the growth is not due to the number of "
        "objects alone.",
        fmt::join(growth.unlike, ", ")));
  return notes;
}

void AddGrowth(const Model& model, const std::vector<std::size_t>& rows, Document& document) {
  const auto growth = figures::GrowthByRow(model, rows);
  if (!growth || growth->exponents.empty()) return;
  Table table;
  AddAxes(model.file(), growth->rows, table);
  table.keys = 1;
  table.AddColumn("p", true);
  if (!growth->is_matched) table.AddColumn("objects", true);
  for (const auto& [point, exponent] : growth->exponents) {
    std::vector<std::string> texts = Coordinates(model.file(), growth->rows, point);
    texts.push_back(ExponentText(exponent.p));
    if (!growth->is_matched) texts.push_back(ObjectsText(exponent));
    table.rows.push_back(std::move(texts));
  }
  document.push_back({.title = fmt::format("Growth over {}: p of detect ~ objects^p{}",
                                           model.axis(growth->axis).name,
                                           growth->is_mean ? ", the mean over all else" : ""),
                      .table = std::move(table),
                      .notes = GrowthNotes(*growth)});
}

}  // namespace

void AddDetectors(const Model& model, const std::vector<std::size_t>& by, Document& document) {
  const auto axis = model.ComparedDetectors();
  if (!axis) return;
  const std::vector<std::size_t> rows = RowsOf(model, *axis, by);
  document.push_back(CostsOf(model, rows));
  AddGrowth(model, rows, document);
}

void AddOtherFaults(const Model& model, Document& document) {
  using Findings = figures::DetectorFindings;
  const auto add = [&](const char* head, std::uint64_t Findings::*count, bool of_exact) {
    std::vector<std::string> faults;
    for (const Findings& of : model.findings())
      if (of.*count > 0)
        faults.push_back(fmt::format("{} {}{}", of.detector, of.*count,
                                     of_exact ? fmt::format(" beside {}", of.exact) : ""));
    if (!faults.empty())
      document.push_back({.title = fmt::format("{}: {}.", head, fmt::join(faults, ", "))});
  };
  add("Pairs listed that do not overlap", &Findings::false_positives, true);
  add("Pairs listed again", &Findings::duplicate, true);
  add("Overlaps without a contact", &Findings::missed_contacts, false);
}

}  // namespace cdb::printers
