// The cells of a results file, for summaries: their list, coordinates, faults and detectors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/store/store.h"

namespace cdb::statistics {

/// In grid order, repeats innermost.
std::vector<store::ResultFile::Cell> AllCells(const store::ResultFile& file);

/// `quantity 10, detector dbvt, rep 0`.
std::string PlaceText(const store::ResultFile& file, const store::ResultFile::Cell& cell);

/// A shell command that runs only this cell: `cdb run crowd.cdb -b crowd --only 0123…`.
std::string OnlyCommand(const store::ResultFile& file, const store::ResultFile::Cell& cell);

/// The axis of detectors; nullopt if the file does not sweep them.
std::optional<std::size_t> DetectorAxis(const store::ResultFile& file);

/// The index of an axis. Throws StoreError that names the axes of the file.
std::size_t FindAxis(const store::ResultFile& file, const std::string& name);

/// The reason why the figures of a cell that was not skipped do not count; nullopt if they do.
std::optional<std::string> Trouble(const store::ResultFile& file,
                                   const store::ResultFile::Cell& cell);

/// For a cell with a trouble, one word: the verdict that voids it (`frozen`), or its status
/// (`crashed`).
std::string FaultOf(const store::ResultFile& file, const store::ResultFile::Cell& cell);

/// The worst verdict among the repeats of a point of the grid.
struct PointVerdict {
  std::string word;                   ///< a verdict; for a run without one, its status (`failed`)
  std::int64_t first_bad_cycle = -1;  ///< the earliest; -1 if none is bad
};
/// Throws StoreError.
PointVerdict WorstVerdict(const store::ResultFile& file, const std::vector<std::size_t>& at);

/// The plan of the results, with the measured runs that are selected; nullopt if it belongs to
/// another version of cdb, whose results are shown as far as possible. A large plan takes seconds
/// to read, so each thread keeps the last one. Throws StoreError.
std::optional<plan::Plan> ReadPlan(const store::ResultFile& file);

/// The detector of each cell. Without an axis of detectors it is taken from the plan, which is read
/// once; if the plan cannot be read, there are no names. Throws StoreError.
class CellDetectors {
 public:
  explicit CellDetectors(const store::ResultFile& file);
  /// Empty if it is unknown.
  std::string Of(const store::ResultFile::Cell& cell) const;

 private:
  const store::ResultFile& file_;
  const std::optional<std::size_t> axis_;
  std::map<std::string, std::string> by_run_;
};

}  // namespace cdb::statistics
