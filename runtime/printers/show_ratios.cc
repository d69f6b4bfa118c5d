// Ratios of the detectors in a comparison to a baseline, for `cdb show`.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "runtime/figures/ratios.h"
#include "runtime/figures/times.h"
#include "runtime/printers/show.h"
#include "runtime/printers/show_parts.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::ComparedPoint;
using figures::Comparison;

/// A sentence if detectors that are compared at one point had different omissions.
std::string UnlikeText(const Comparison& comparison) {
  std::set<std::string> components;
  std::size_t unlike = 0;
  for (const ComparedPoint& point : comparison.points) {
    components.insert(point.unlike.begin(), point.unlike.end());
    unlike += point.unlike.empty() ? 0 : 1;
  }
  if (unlike == 0) return {};
  return fmt::format(
      "At {} of {} points, some detectors ran without {} and others with it: these ratios are "
      "not due to the detectors alone. omit none makes them alike.",
      unlike, comparison.points.size(), fmt::join(components, ", "));
}

class RatioTable {
 public:
  explicit RatioTable(const Comparison& comparison)
      : comparison_(comparison),
        file_(comparison.model->file()),
        times_(comparison.model->times()),
        detector_(file_.axes()[comparison.axis]),
        others_(figures::OtherAxes(file_, comparison.axis)) {}

  Section Made(protocol::Phase phase) {
    Table table;
    AddAxes(file_, others_, table);
    if (others_.empty()) table.AddColumn("", false);
    table.keys = HeadSize();
    for (std::size_t i = 0; i < detector_.values.size(); ++i)
      table.AddColumn(terminal::CoordinateText(detector_, i), true);
    if (comparison_.points.size() <= kMaxRows)
      for (const ComparedPoint& point : comparison_.points) AddPoint(table, point, phase);
    if (comparison_.points.size() > 1) AddMeans(table, phase);
    return {.title = fmt::format("{} {} over that of {}{}", times_.StatisticHead(),
                                 figures::PhaseName(phase),
                                 terminal::CoordinateText(detector_, comparison_.baseline),
                                 comparison_.points.size() > 1 ? " (geometric mean below)" : ""),
            .table = std::move(table),
            .notes = Legend()};
  }

 private:
  std::size_t HeadSize() const { return std::max<std::size_t>(1, others_.size()); }

  void AddPoint(Table& table, const ComparedPoint& point, protocol::Phase phase) {
    std::vector<std::string> row = Coordinates(file_, others_, point.at), below;
    row.resize(HeadSize());
    below.resize(HeadSize());
    for (std::size_t i = 0; i < detector_.values.size(); ++i) {
      const auto ratio = comparison_.RatioAt(point, i, phase);
      const std::string text = ratio ? terminal::ShortNumber(ratio->value) : "-";
      const bool counts = point.is_matched && !comparison_.is_void;
      row.push_back(counts || !ratio ? text : "(" + text + ")");
      has_parentheses_ = has_parentheses_ || (ratio && !counts);
      below.push_back(ratio && i != comparison_.baseline
                          ? figures::IntervalText(times_.IntervalOf(*ratio))
                          : "");
    }
    table.rows.push_back(std::move(row));
    const bool is_empty = std::ranges::all_of(below, &std::string::empty);
    if (times_.HasIntervals() && !is_empty) table.rows.push_back(std::move(below));
  }

  void AddMeans(Table& table, protocol::Phase phase) {
    std::vector<std::string> mean(HeadSize()), interval(HeadSize()), range(HeadSize());
    mean[0] = "mean";
    range[0] = "range";
    for (std::size_t i = 0; i < detector_.values.size(); ++i) {
      const auto all = figures::MeanRatioOf(comparison_, i, phase);
      if (!all || !all->is_matched) {
        for (auto* row : {&mean, &interval, &range}) row->push_back("-");
        continue;
      }
      const std::string text = terminal::ShortNumber(all->mean.value);
      mean.push_back(comparison_.is_void ? "(" + text + ")" : text);
      interval.push_back(i == comparison_.baseline ? "" : figures::IntervalText(all->interval));
      range.push_back(figures::IntervalText({all->least, all->most}));
    }
    table.rows.push_back(std::move(mean));
    if (times_.HasIntervals()) table.rows.push_back(std::move(interval));
    table.rows.push_back(std::move(range));
  }

  /// Explains the numbers below each ratio, and the means.
  std::vector<std::string> Legend() const {
    std::vector<std::string> notes = {"No interval: one repeat."};
    if (times_.bootstrap().kind() == figures::IntervalKind::kRange)
      notes[0] =
          "Below each ratio its range over all draws of repeats, the same for both detectors.";
    if (times_.bootstrap().kind() == figures::IntervalKind::kInterval)
      notes[0] =
          "Below each ratio its 95 % interval: bootstrap over repeats, the same for both "
          "detectors.";
    const std::size_t all = comparison_.points.size(), matched = comparison_.MatchedCount();
    if (all > 1)
      notes.push_back(fmt::format("Mean and range over {} of {} cells{}.", matched, all,
                                  matched < all ? ": those that all detectors have" : ""));
    if (comparison_.is_void)
      notes.emplace_back("In parentheses: every run is void.");
    else if (has_parentheses_)
      notes.emplace_back("In parentheses: a detector is void, missing, or has other omissions.");
    return notes;
  }

  const Comparison& comparison_;
  const results::ResultFile& file_;
  const figures::CycleTimes& times_;
  const plan::Axis& detector_;
  const std::vector<std::size_t> others_;  ///< indices of axes
  bool has_parentheses_ = false;           ///< some ratio is not included in the means
};

}  // namespace

void AddRatios(const figures::Model& model, const std::string& baseline,
               const std::vector<protocol::Phase>& phases, Document& document) {
  const auto comparison = figures::CompareDetectors(model, baseline);
  if (!comparison) return;
  RatioTable table(*comparison);
  if (std::string text = UnlikeText(*comparison); !text.empty())
    document.push_back({.title = std::move(text)});
  for (const protocol::Phase phase :
       phases.empty() ? std::vector{protocol::Phase::kDetect, protocol::Phase::kStep} : phases)
    document.push_back(table.Made(phase));
}

}  // namespace cdb::printers
