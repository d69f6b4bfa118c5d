// What the parts of a results document (results_document.h) are made from.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/document/json_numbers.h"
#include "runtime/report/cycle_times.h"
#include "runtime/report/figures.h"
#include "runtime/report/findings.h"
#include "runtime/report/points.h"
#include "runtime/store/store.h"

namespace cdb::document {

/// Of points up to which a document has all statistics of all phases.
inline constexpr std::size_t kMaxWholePoints = 5000;

class DocumentSource {
 public:
  /// A point of the grid that some run was made at.
  struct GridPoint {
    report::Point at;
    const report::MeasuredPoint* measured;  ///< null where no repeat has cycles
  };

  /// Throws StoreError.
  DocumentSource(const store::ResultFile& file, bool only_sound,
                 report::CycleStatistic statistic = report::CycleStatistic::kMean);
  DocumentSource(const DocumentSource&) = delete;
  DocumentSource& operator=(const DocumentSource&) = delete;

  const store::ResultFile& file() const { return file_; }
  const std::vector<report::MeasuredPoint>& measured() const { return measured_; }
  /// The rows of the document's columns, in grid order.
  const std::vector<GridPoint>& points() const { return points_; }
  /// The place of a point among `points()`.
  std::size_t IndexOf(const report::Point& at) const { return index_.at(at); }
  report::CycleTimes& times() const { return times_; }
  const report::CellGroups& groups() const { return groups_; }
  const std::vector<report::DetectorFindings>& findings() const { return findings_; }
  /// Why reference runs are of no use, a line each.
  const std::vector<std::string>& references() const { return references_; }

  bool HasTimes() const { return file_.Has("duration"); }
  /// More than kMaxWholePoints: only the figures that a page can hold.
  bool IsLarge() const { return points_.size() > kMaxWholePoints; }
  int digits() const { return IsLarge() ? 4 : 6; }
  Json Number(double value) const { return JsonNumber(value, digits()); }

  /// A value on an axis: a number or a text.
  Json Value(std::size_t axis, std::size_t index) const;
  /// `{"quantity": 100}`: the values on the axes `axes`, at the point `at` on them.
  Json Place(const std::vector<std::size_t>& axes, const report::Point& at) const;

 private:
  const store::ResultFile& file_;
  const std::vector<report::MeasuredPoint> measured_;
  std::vector<GridPoint> points_;
  std::map<report::Point, std::size_t> index_;
  mutable report::CycleTimes times_;  ///< computes when asked
  const report::CellGroups groups_;
  const std::vector<report::DetectorFindings> findings_;
  const std::vector<std::string> references_;
};

/// A line for a terminal as a sentence for a page: without its indent and its end of line.
std::string Sentence(std::string_view line);

}  // namespace cdb::document
