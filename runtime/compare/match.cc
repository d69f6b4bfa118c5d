#include "runtime/compare/match.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "runtime/statistics/cells.h"
#include "runtime/terminal/table.h"

namespace cdb::compare {
namespace {

using statistics::AxisSelection;
using Cell = store::ResultFile::Cell;

/// The selected part of an axis.
struct SelectedAxis {
  std::size_t place = 0;            ///< index of the axis in the file
  std::vector<std::size_t> values;  ///< indices of the selected values
};
using SelectedAxes = std::map<std::string, SelectedAxis>;

/// The indices of the selected values; all if the axis has no selection.
std::vector<std::size_t> SelectValues(const plan::Axis& axis,
                                      const std::vector<AxisSelection>& selections) {
  std::set<std::size_t> indices;
  bool is_selected = false;
  for (const AxisSelection& selection : selections) {
    if (selection.axis != axis.name) continue;
    is_selected = true;
    const statistics::NamedValues values = statistics::FindValues(axis, selection.text);
    indices.insert(values.indices.begin(), values.indices.end());
  }
  if (is_selected) return {indices.begin(), indices.end()};
  std::vector<std::size_t> all(axis.values.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

SelectedAxes SelectAxes(const ComparedFile& of, const std::vector<AxisSelection>& selections) {
  SelectedAxes selected;
  const std::vector<plan::Axis>& axes = of.file.axes();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    selected[axes[i].name] = {i, SelectValues(axes[i], selections)};
    if (!selected[axes[i].name].values.empty()) continue;
    throw files::StoreError(fmt::format("--select {}: {} has none of these values; it has {}",
                                        axes[i].name, of.name, statistics::ValuesText(axes[i])));
  }
  return selected;
}

void CheckSelections(const ComparedFile& a, const ComparedFile& b,
                     const std::vector<AxisSelection>& selections) {
  std::vector<std::string> names;
  for (const ComparedFile* of : {&a, &b})
    for (const plan::Axis& axis : of->file.axes())
      if (std::ranges::find(names, axis.name) == names.end()) names.push_back(axis.name);
  for (const AxisSelection& selection : selections)
    if (std::ranges::find(names, selection.axis) == names.end())
      throw files::StoreError(fmt::format("--select: there is no axis '{}'; there are {}",
                                          selection.axis, fmt::join(names, ", ")));
}

/// True if its cells are neither skipped nor missing.
bool Ran(const store::ResultFile& file, const statistics::Point& at) {
  for (std::uint64_t rep = 0; rep < file.repeats(); ++rep) {
    const store::Status status = file.ReadStatus({at, rep});
    if (status != store::Status::kSkipped && status != store::Status::kMissing) return true;
  }
  return false;
}

class Matcher {
 public:
  Matcher(const ComparedFile& a, const ComparedFile& b,
          const std::vector<AxisSelection>& selections)
      : a_(a), b_(b), axes_a_(SelectAxes(a, selections)), axes_b_(SelectAxes(b, selections)) {}

  PointMatch Match() {
    ChooseAxes(a_, axes_a_, b_, axes_b_);
    for (const auto& [name, axis] : axes_b_)
      if (!axes_a_.contains(name)) IgnoreAxis(b_, name, axis);
    MatchCells();
    if (match_.points.empty())
      throw files::StoreError(fmt::format(
          "{} and {} have no point in common: {} has {}{}; {} has {}{}", a_.name, b_.name, a_.name,
          FirstOf(match_.only_a), match_.only_a.size() > 1 ? ", …" : "", b_.name,
          FirstOf(match_.only_b), match_.only_b.size() > 1 ? ", …" : ""));
    return std::move(match_);
  }

 private:
  using Key = std::vector<plan::Coordinate>;

  static std::string FirstOf(const std::vector<std::string>& points) {
    return points.empty() ? "none" : points[0];
  }

  /// For an axis that the other file lacks, or has with another value.
  void IgnoreAxis(const ComparedFile& of, const std::string& name, const SelectedAxis& axis) {
    const std::string values = statistics::ValuesText(of.file.axes()[axis.place], axis.values);
    if (axis.values.size() > 1)
      throw files::StoreError(fmt::format(
          "only {} has the axis '{}' ({}): choose one of its values, such as --select {}={}",
          of.name, name, values, name, terminal::CoordinateText(of.file.axes()[axis.place], 0)));
    match_.notes.push_back(
        fmt::format("only {} has the axis {}, with the value {}", of.name, name, values));
  }

  void ChooseAxes(const ComparedFile& a, const SelectedAxes& of_a, const ComparedFile& b,
                  const SelectedAxes& of_b) {
    for (const plan::Axis& axis : a.file.axes()) {
      const SelectedAxis& here = of_a.at(axis.name);
      const auto there = of_b.find(axis.name);
      if (there == of_b.end()) {
        IgnoreAxis(a, axis.name, here);
        continue;
      }
      const plan::Axis& other = b.file.axes()[there->second.place];
      if (here.values.size() == 1 && there->second.values.size() == 1 &&
          axis.values[here.values[0]] != other.values[there->second.values[0]]) {
        match_.notes.push_back(fmt::format(
            "{}: {} in {}, {} in {}", axis.name, terminal::CoordinateText(axis, here.values[0]),
            a.name, terminal::CoordinateText(other, there->second.values[0]), b.name));
        continue;
      }
      if (axis.IsText() &&
          (!match_.group || (axis.parameter == "detector" && !group_is_detector_))) {
        match_.group = match_.axes.size();
        group_is_detector_ = axis.parameter == "detector";
      }
      match_.axes.push_back(axis.name);
      match_.is_text.push_back(axis.IsText());
    }
  }

  /// The selected points that ran, keyed by their values on the axes of the match.
  std::vector<std::pair<Key, statistics::Point>> PointsOf(const ComparedFile& of,
                                                          const SelectedAxes& selected) const {
    std::vector<std::pair<Key, statistics::Point>> points;
    for (const Cell& cell : statistics::AllCells(of.file)) {
      if (cell.rep != 0) continue;
      const bool is_selected = std::ranges::all_of(selected, [&](const auto& axis) {
        return std::ranges::find(axis.second.values, cell.at[axis.second.place]) !=
               axis.second.values.end();
      });
      if (!is_selected || !Ran(of.file, cell.at)) continue;
      Key key;
      for (const std::string& name : match_.axes) {
        const std::size_t place = selected.at(name).place;
        key.push_back(of.file.axes()[place].values[cell.at[place]]);
      }
      points.emplace_back(std::move(key), cell.at);
    }
    return points;
  }

  std::vector<std::string> PlaceOf(const ComparedFile& of, const SelectedAxes& selected,
                                   const statistics::Point& at) const {
    std::vector<std::string> place;
    for (const std::string& name : match_.axes) {
      const std::size_t axis = selected.at(name).place;
      place.push_back(terminal::CoordinateText(of.file.axes()[axis], at[axis]));
    }
    return place;
  }

  void MatchCells() {
    auto of_b = PointsOf(b_, axes_b_);
    std::map<Key, statistics::Point> left(of_b.begin(), of_b.end());
    for (const auto& [key, at] : PointsOf(a_, axes_a_)) {
      MatchedPoint point = {at, {}, PlaceOf(a_, axes_a_, at)};
      const auto found = left.find(key);
      if (found == left.end()) {
        match_.only_a.push_back(point.PlaceText(match_.axes));
        continue;
      }
      point.b = found->second;
      left.erase(found);
      match_.points.push_back(std::move(point));
    }
    for (const auto& [key, at] : of_b)
      if (left.contains(key))
        match_.only_b.push_back(
            MatchedPoint{{}, at, PlaceOf(b_, axes_b_, at)}.PlaceText(match_.axes));
  }

  const ComparedFile &a_, &b_;
  const SelectedAxes axes_a_, axes_b_;
  PointMatch match_;
  bool group_is_detector_ = false;
};

}  // namespace

ComparedFile::ComparedFile(const std::filesystem::path& path, std::string name_of)
    : name(std::move(name_of)),
      file(path),
      plan(statistics::ReadPlan(file)),
      points(statistics::MeasuredPoints(file, false)) {}

std::string MatchedPoint::PlaceText(const std::vector<std::string>& axes) const {
  std::string text;
  for (std::size_t i = 0; i < axes.size(); ++i)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", axes[i], place[i]);
  return text.empty() ? "the only point" : text;
}

PointMatch MatchPoints(const ComparedFile& a, const ComparedFile& b,
                       const std::vector<AxisSelection>& selections) {
  CheckSelections(a, b, selections);
  return Matcher(a, b, selections).Match();
}

}  // namespace cdb::compare
