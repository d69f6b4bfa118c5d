// Changes over the commits of a project as text and JSON (`cdb history`).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/figures/history/histories.h"
#include "runtime/printers/document.h"

namespace cdb::printers {

/// `2026-03-01`, of the seconds since 1970; empty if they are unknown (0).
std::string DayOf(double started);

/// All of a command.
struct PrintedHistories {
  std::string folder;
  std::vector<history::History> histories;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< a file, and why
  std::size_t files = 0, read = 0;   ///< number of files, and of those that were not in the cache
  std::optional<double> since = {};  ///< changes up to this place of a file are not reported
  std::optional<double> fail_above = {};
  /// If the files are in order of commits: the oldest first. Places of files are their indices.
  std::vector<history::Commit> commits = {};

  /// The index of the last file up to `since`; 0 if there is none, and without `since`.
  std::size_t SinceOf(const history::History& of) const;
  /// The series that became worse since then by more than `fail_above`, as indices.
  std::vector<std::size_t> WorseSeries(const history::History& of) const;
  bool IsFailed() const;
};

/// A section for each history: its files, and the changes, the newest first; then the curves of the
/// series that changed most.
Document HistoriesDocument(const PrintedHistories& printed);

/// `cdb doc history` describes the members.
std::string HistoriesJson(const PrintedHistories& printed);

/// The same for a page, with the sections that a terminal shows.
std::string HistoriesPageJson(const PrintedHistories& printed);

}  // namespace cdb::printers
