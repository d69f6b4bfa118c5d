#include "runtime/report/show_ratios.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string_view>

#include "runtime/report/cells.h"
#include "runtime/report/figures.h"
#include "runtime/report/show.h"
#include "runtime/report/table.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;

/// A line where detectors that are compared at one point did not leave out the same.
std::string UnlikeText(const UnlikeOmissions& unlike) {
  if (unlike.unlike_points == 0) return {};
  return fmt::format(
      "\nAt {} of {} points some detectors ran without {} and others with: their ratios there "
      "are not of the detectors alone. omit none makes them alike.\n",
      unlike.unlike_points, unlike.points, fmt::join(unlike.components, ", "));
}

class RatioTable {
 public:
  RatioTable(const store::ResultFile& file, std::size_t detector_axis)
      : file_(file), detector_(file.axes()[detector_axis]), others_(file.axes().size()) {
    std::iota(others_.begin(), others_.end(), std::size_t{0});
    std::erase(others_, detector_axis);
  }

  std::string Text(const DetectorMedians& points, std::string_view phase) const {
    Table table;
    AddColumns(table);
    std::vector<std::vector<double>> ratios(detector_.values.size());
    for (const auto& [point, medians] : points) {
      std::vector<std::string> row = RowHead(point);
      for (std::size_t i = 0; i < medians.size(); ++i) {
        const double ratio = medians[i] / medians[0];
        row.push_back(ShortNumber(ratio));
        if (std::isfinite(ratio)) ratios[i].push_back(ratio);
      }
      if (points.size() <= kMaxRows) table.AddRow(std::move(row));
    }
    if (points.size() > 1) AddMeans(table, std::move(ratios));
    return fmt::format("\nMedian of {} over that of {}{}\n{}", phase, CoordinateText(detector_, 0),
                       points.size() > 1 ? " (geometric mean below)" : "", table.Text());
  }

 private:
  bool HasRepeats() const { return file_.repeats() > 1; }

  void AddColumns(Table& table) const {
    for (const std::size_t axis : others_)
      table.AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
    if (HasRepeats()) table.AddColumn("rep", true);
    if (others_.empty() && !HasRepeats()) table.AddColumn("", false);
    for (std::size_t i = 0; i < detector_.values.size(); ++i)
      table.AddColumn(CoordinateText(detector_, i), true);
  }

  std::vector<std::string> RowHead(const ComparedPoint& point) const {
    std::vector<std::string> row;
    for (std::size_t i = 0; i < others_.size(); ++i)
      row.push_back(CoordinateText(file_.axes()[others_[i]], point.first[i]));
    if (HasRepeats()) row.push_back(fmt::format("{}", point.second));
    if (others_.empty() && !HasRepeats()) row.emplace_back();
    return row;
  }

  void AddMeans(Table& table, std::vector<std::vector<double>> ratios) const {
    std::vector<std::string> mean(others_.size() + (HasRepeats() ? 1 : 0)), range;
    mean[0] = "mean";
    range = mean;
    range[0] = "range";
    for (auto& of_detector : ratios) {
      mean.push_back(ShortNumber(GeometricMean(of_detector)));
      std::ranges::sort(of_detector);
      range.push_back(of_detector.empty() ? "-"
                                          : ShortNumber(of_detector.front()) + " .. " +
                                                ShortNumber(of_detector.back()));
    }
    table.AddRow(std::move(mean));
    table.AddRow(std::move(range));
  }

  const store::ResultFile& file_;
  const plan::Axis& detector_;
  std::vector<std::size_t> others_;  ///< axes
};

}  // namespace

std::string ShowRatios(const store::ResultFile& file, const std::vector<Cell>& cells) {
  const auto axis = DetectorAxis(file);
  if (!axis || file.axes()[*axis].values.size() < 2 || !file.Has("duration")) return {};
  const RatioTable table(file, *axis);
  std::string text = UnlikeText(FindUnlikeOmissions(file, cells, *axis));
  for (const auto& [phase, name] :
       {std::pair{measure::Phase::kDetect, "detect"}, std::pair{measure::Phase::kStep, "step"}})
    text += table.Text(MediansByDetector(file, cells, *axis, phase), name);
  return text;
}

}  // namespace cdb::report
