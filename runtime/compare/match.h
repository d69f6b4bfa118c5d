// Matches the points of two results files for comparison (`cdb compare`).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "runtime/figures/model.h"
#include "runtime/figures/selection.h"
#include "runtime/store/store.h"

namespace cdb::compare {

/// A results file in a comparison, with the data that is read from it once.
struct ComparedFile {
  /// `name`: for the output; differs from those of the other files. Throws StoreError.
  ComparedFile(const std::filesystem::path& path, std::string name);
  ComparedFile(const ComparedFile&) = delete;
  ComparedFile& operator=(const ComparedFile&) = delete;

  const std::string name;
  const store::ResultFile file;
  const std::optional<plan::Plan> plan;  ///< nullopt for a plan of another version of cdb
  const figures::Model model;
};

/// A point that both files have.
struct MatchedPoint {
  figures::Point a, b;             ///< the point in each file
  std::vector<std::string> place;  ///< its value on each axis of PointMatch
  std::string PlaceText(const std::vector<std::string>& axes) const;
};

struct PointMatch {
  std::vector<std::string> axes;            ///< the axes by which points are matched
  std::vector<bool> is_text;                ///< for each of the axes
  std::optional<std::size_t> group;         ///< the axis of detectors, else the first axis of texts
  std::vector<MatchedPoint> points;         ///< in the grid order of a
  std::vector<std::string> only_a, only_b;  ///< points without a match, for the output
  std::vector<std::string> notes;           ///< about axes that are ignored
};
/// Matches points by the names and values of axes. An axis with one value that only one file has,
/// or whose one value differs between the files, is ignored, with a note. Throws StoreError for an
/// axis with several values that only one file has, for a selection that neither file has, and if
/// no point is left.
PointMatch MatchPoints(const ComparedFile& a, const ComparedFile& b,
                       const std::vector<figures::AxisSelection>& selections);

}  // namespace cdb::compare
