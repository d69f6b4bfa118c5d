#include "runtime/figures/rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace cdb::figures {
namespace {

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

std::string Row::CellsText() const {
  return points.size() == own ? fmt::format("{}", own)
                              : fmt::format("{} of {}", points.size(), own);
}

std::vector<std::string> Rows::MatchNotes() const {
  std::vector<std::string> notes;
  if (!pools) return notes;
  if (std::ranges::any_of(rows, [](const Row& row) { return row.points.size() < row.own; }))
    notes.emplace_back("A row pools only the cells that all rows of its kind have: k of its n.");
  if (is_unmatched)
    notes.emplace_back(
        "No cell is in all rows of a kind, so each row has different cells: do not compare them.");
  return notes;
}

Rows MatchRows(const std::vector<const MeasuredPoint*>& points, std::vector<std::size_t> by) {
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
    kinds[row.mark].push_back(&row);
  }
  for (const auto& [mark, rows] : kinds)
    if (!Match(rows, by)) all.is_unmatched = true;
  all.pools = all.pools || all.is_unmatched;
  for (auto& [key, row] : found) all.rows.push_back(std::move(row));
  all.by = std::move(by);
  return all;
}

Rows MatchRows(const std::vector<MeasuredPoint>& points, std::vector<std::size_t> by) {
  std::vector<const MeasuredPoint*> all;
  for (const MeasuredPoint& point : points) all.push_back(&point);
  return MatchRows(all, std::move(by));
}

}  // namespace cdb::figures
