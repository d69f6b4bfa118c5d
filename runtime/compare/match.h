// Which points of two results files are compared with each other (`cdb compare`).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "runtime/statistics/axis_values.h"
#include "runtime/statistics/points.h"
#include "runtime/store/store.h"

namespace cdb::compare {

/// A results file of a comparison, with what is read from it once.
struct ComparedFile {
  /// `name`: for people, unlike that of the other files. Throws StoreError.
  ComparedFile(const std::filesystem::path& path, std::string name);
  ComparedFile(const ComparedFile&) = delete;
  ComparedFile& operator=(const ComparedFile&) = delete;

  const std::string name;
  const store::ResultFile file;
  const std::optional<plan::Plan> plan;  ///< nullopt for that of another version of cdb
  const std::vector<statistics::MeasuredPoint> points;
};

/// A point that both files have.
struct MatchedPoint {
  statistics::Point a, b;          ///< its place in each
  std::vector<std::string> place;  ///< its value on each axis of PointMatch
  std::string PlaceText(const std::vector<std::string>& axes) const;
};

struct PointMatch {
  std::vector<std::string> axes;            ///< that points are matched by
  std::vector<bool> is_text;                ///< of the axes
  std::optional<std::size_t> group;         ///< the axis of detectors, else the first of texts
  std::vector<MatchedPoint> points;         ///< in the grid order of a
  std::vector<std::string> only_a, only_b;  ///< the other points, for people
  std::vector<std::string> notes;           ///< about axes that are ignored
};
/// Matches points by the names and values of axes. An axis of one value that only one file has, or
/// that is another value in the other, matches nothing; a note says so. Throws StoreError for an
/// axis of several values that only one file has, for a selection that neither has, and if no point
/// is left.
PointMatch MatchPoints(const ComparedFile& a, const ComparedFile& b,
                       const std::vector<statistics::AxisSelection>& selections);

}  // namespace cdb::compare
