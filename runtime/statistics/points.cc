#include "runtime/statistics/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "compiler/analysis/pruning.h"
#include "compiler/schema/schema.h"
#include "runtime/statistics/cells.h"

namespace cdb::statistics {
namespace {

using Cell = store::ResultFile::Cell;

bool IsIn(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

void ReadOmissions(const store::ResultFile& file, MeasuredPoint& point) {
  if (!file.Has("omitted") || !file.Has("needs")) return;
  const std::string omitted = file.ReadText("omitted", point.cells[0]),
                    needs = file.ReadText("needs", point.cells[0]);
  for (const schema::ComponentInfo& info : schema::Components()) {
    if (!info.IsVisible()) continue;
    if (schema::ListsWord(omitted, info.name)) {
      point.left_out.emplace_back(info.name);
    } else if (analysis::SaysKept(needs, info.component)) {
      point.kept.emplace_back(info.name);
    }
  }
}

/// The point without its repeats that have no cycles; nullopt if none has any.
std::optional<MeasuredPoint> ReadPoint(const store::ResultFile& file, const Point& at) {
  MeasuredPoint point{at, {}, "", {}, {}, {}};
  std::vector<Cell> faulty;
  for (std::uint64_t rep = 0; rep < file.repeats(); ++rep) {
    const Cell cell{at, rep};
    const store::Status status = file.ReadStatus(cell);
    if (status == store::Status::kSkipped || status == store::Status::kMissing ||
        file.ReadCycleCount(cell) == 0)
      continue;
    (Trouble(file, cell) ? faulty : point.cells).push_back(cell);
  }
  if (point.cells.empty() && !faulty.empty()) {
    point.fault = FaultOf(file, faulty[0]);
    point.cells = std::move(faulty);
  }
  if (point.cells.empty()) return std::nullopt;
  ReadOmissions(file, point);
  return point;
}

/// The coordinates of the point on the axes that make no rows.
Point RestOf(const MeasuredPoint& point, const std::vector<std::size_t>& by) {
  Point rest;
  for (std::size_t i = 0; i < point.at.size(); ++i)
    if (std::ranges::find(by, i) == by.end()) rest.push_back(point.at[i]);
  return rest;
}

/// Drops the points that some of `rows`, which are of one kind, lack. False if none would remain.
bool Match(const std::vector<Row*>& rows, const std::vector<std::size_t>& by) {
  std::map<Point, std::size_t> counts;
  for (const Row* row : rows)
    for (const MeasuredPoint* point : row->points) ++counts[RestOf(*point, by)];
  std::erase_if(counts, [&](const auto& cell) { return cell.second < rows.size(); });
  if (counts.empty()) return false;
  for (Row* row : rows)
    std::erase_if(row->points,
                  [&](const MeasuredPoint* point) { return !counts.contains(RestOf(*point, by)); });
  return true;
}

}  // namespace

Point Project(const Point& at, const std::vector<std::size_t>& axes) {
  Point part;
  for (const std::size_t axis : axes) part.push_back(at[axis]);
  return part;
}

Point Without(Point at, std::size_t axis) {
  at.erase(at.begin() + static_cast<std::ptrdiff_t>(axis));
  return at;
}

std::string MeasuredPoint::Mark() const {
  const std::string without =
      unlike.empty() ? "" : fmt::format("without {}", fmt::join(unlike, ", "));
  return fault + (fault.empty() || without.empty() ? "" : ", ") + without;
}

std::vector<std::string> MeasuredPoint::UnlikeComponents(const MeasuredPoint& other) const {
  std::vector<std::string> components;
  for (const std::string& name : left_out)
    if (IsIn(other.kept, name)) components.push_back(name);
  for (const std::string& name : other.left_out)
    if (IsIn(kept, name)) components.push_back(name);
  return components;
}

std::vector<MeasuredPoint> MeasuredPoints(const store::ResultFile& file, bool only_sound) {
  std::vector<MeasuredPoint> points;
  std::set<std::string> kept_somewhere;
  for (const Cell& cell : AllCells(file)) {
    if (cell.rep != 0) continue;
    auto point = ReadPoint(file, cell.at);
    if (!point || (only_sound && !point->IsSound())) continue;
    kept_somewhere.insert(point->kept.begin(), point->kept.end());
    points.push_back(*std::move(point));
  }
  for (MeasuredPoint& point : points)
    std::ranges::copy_if(point.left_out, std::back_inserter(point.unlike),
                         [&](const std::string& name) { return kept_somewhere.contains(name); });
  return points;
}

std::string Rows::CellsText(const Row& row) {
  return row.points.size() == row.own ? fmt::format("{}", row.own)
                                      : fmt::format("{} of {}", row.points.size(), row.own);
}

std::string Rows::MatchLines() const {
  if (!pools) return {};
  const bool drops =
      std::ranges::any_of(rows, [](const Row& row) { return row.points.size() < row.own; });
  std::string text;
  if (drops) text += "  A row pools only the cells that all rows of its kind have: k of its n.\n";
  if (is_unmatched)
    text +=
        "  No cell is in all rows of a kind, so each row has different cells: do not compare "
        "them.\n";
  return text;
}

Rows MatchRows(const std::vector<const MeasuredPoint*>& points,
               const std::vector<std::size_t>& by) {
  std::map<std::tuple<Point, bool, std::string>, Row> found;
  for (const MeasuredPoint* point : points) {
    const Point at = Project(point->at, by);
    Row& row = found[{at, !point->IsSound(), point->Mark()}];
    row.at = at;
    row.mark = point->Mark();
    row.is_void = !point->IsSound();
    row.points.push_back(point);
  }
  Rows all;
  std::map<std::string, std::vector<Row*>> kinds;
  for (auto& [key, row] : found) {
    row.own = row.points.size();
    all.pools = all.pools || row.own > 1;
    all.has_marks = all.has_marks || !row.mark.empty();
    kinds[row.mark].push_back(&row);
  }
  for (const auto& [mark, rows] : kinds)
    if (!Match(rows, by)) all.is_unmatched = true;
  all.pools = all.pools || all.is_unmatched;
  for (auto& [key, row] : found) all.rows.push_back(std::move(row));
  return all;
}

Rows MatchRows(const std::vector<MeasuredPoint>& points, const std::vector<std::size_t>& by) {
  std::vector<const MeasuredPoint*> all;
  for (const MeasuredPoint& point : points) all.push_back(&point);
  return MatchRows(all, by);
}

}  // namespace cdb::statistics
