// The data that the parts of a results document (results_document.h) share.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/document/json_numbers.h"
#include "runtime/statistics/cycle_times.h"
#include "runtime/statistics/figures.h"
#include "runtime/statistics/findings.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::document {

/// The largest number of points for which a document has all statistics of all phases.
inline constexpr std::size_t kMaxWholePoints = 5000;

class DocumentSource {
 public:
  /// A point of the grid with at least one run.
  struct GridPoint {
    statistics::Point at;
    const statistics::MeasuredPoint* measured;  ///< null if no repeat has cycles
  };

  /// Throws StoreError.
  DocumentSource(const store::ResultFile& file, bool only_sound,
                 statistics::CycleStatistic statistic = statistics::CycleStatistic::kMean);
  DocumentSource(const DocumentSource&) = delete;
  DocumentSource& operator=(const DocumentSource&) = delete;

  const store::ResultFile& file() const { return file_; }
  const std::vector<statistics::MeasuredPoint>& measured() const { return measured_; }
  /// The rows of the document's columns, in grid order.
  const std::vector<GridPoint>& points() const { return points_; }
  /// The index of a point in `points()`.
  std::size_t IndexOf(const statistics::Point& at) const { return index_.at(at); }
  statistics::CycleTimes& times() const { return times_; }
  const statistics::CellGroups& groups() const { return groups_; }
  const std::vector<statistics::DetectorFindings>& findings() const { return findings_; }
  /// The reasons why reference runs cannot be used, a line each.
  const std::vector<std::string>& references() const { return references_; }

  bool HasTimes() const { return file_.Has("duration"); }
  /// More than kMaxWholePoints points: the document has only the figures that a page can hold.
  bool IsLarge() const { return points_.size() > kMaxWholePoints; }
  int digits() const { return IsLarge() ? 4 : 6; }
  Json Number(double value) const { return JsonNumber(value, digits()); }

  /// A value on an axis: a number or a text.
  Json Value(std::size_t axis, std::size_t index) const;
  /// `{"quantity": 100}`: the values on the axes `axes`, at the point `at` on them.
  Json Place(const std::vector<std::size_t>& axes, const statistics::Point& at) const;

 private:
  const store::ResultFile& file_;
  const std::vector<statistics::MeasuredPoint> measured_;
  std::vector<GridPoint> points_;
  std::map<statistics::Point, std::size_t> index_;
  mutable statistics::CycleTimes times_;  ///< computed on demand
  const statistics::CellGroups groups_;
  const std::vector<statistics::DetectorFindings> findings_;
  const std::vector<std::string> references_;
};

/// Turns a line for a terminal into a sentence for a page: without indent and line end.
std::string Sentence(std::string_view line);

}  // namespace cdb::document
