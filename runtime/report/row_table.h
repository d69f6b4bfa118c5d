// A table of matched rows: the axes, the cells that each row pools, figures, and the mark.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/statistics/points.h"
#include "runtime/store/store.h"
#include "runtime/terminal/table.h"

namespace cdb::report {

/// Refers to its arguments and to its rows, which must outlive it.
class RowTable {
 public:
  RowTable(const store::ResultFile& file, const std::vector<std::size_t>& by, bool pools)
      : file_(file), by_(by), pools_(pools) {}

  /// A column of figures, aligned to the right.
  void AddColumn(std::string_view head) { heads_.emplace_back(head); }
  /// A figure for each column. `note` precedes the row's mark.
  void AddRow(const statistics::Row& row, std::vector<std::string> figures,
              const std::string& note = "");
  std::string Text() const;

 private:
  struct Line {
    const statistics::Row& row;
    std::vector<std::string> figures;
    std::string note;
  };

  const store::ResultFile& file_;
  const std::vector<std::size_t>& by_;
  const bool pools_;
  std::vector<std::string> heads_;
  std::vector<Line> lines_;
};

/// The first columns of a row: its coordinates.
std::vector<std::string> Coordinates(const store::ResultFile& file,
                                     const std::vector<std::size_t>& axes,
                                     const statistics::Point& at);

}  // namespace cdb::report
