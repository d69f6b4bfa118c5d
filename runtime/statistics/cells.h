// The cells of a results file, for summaries: which there are, where they stand, and by which
// detector.
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

/// What a shell takes to run the cell by itself: `cdb run crowd.cdb -b crowd --only 0123…`.
std::string OnlyCommand(const store::ResultFile& file, const store::ResultFile::Cell& cell);

/// The axis of detectors; nullopt where the file sweeps none.
std::optional<std::size_t> DetectorAxis(const store::ResultFile& file);

/// The place of an axis. Throws StoreError that names those of the file.
std::size_t FindAxis(const store::ResultFile& file, const std::string& name);

/// Why the figures of a cell that was not skipped do not count; nullopt where they do.
std::optional<std::string> Trouble(const store::ResultFile& file,
                                   const store::ResultFile::Cell& cell);

/// Of a cell with a trouble, one word: the verdict that voids it (`frozen`), or its status
/// (`crashed`).
std::string FaultOf(const store::ResultFile& file, const store::ResultFile::Cell& cell);

/// How a point of the grid ended: of its repeats, the worst.
struct PointVerdict {
  std::string word;  ///< a verdict; of a run without one, how its process ended (`failed`)
  std::int64_t first_bad_cycle = -1;  ///< the earliest; -1 where none is bad
};
/// Throws StoreError.
PointVerdict WorstVerdict(const store::ResultFile& file, const std::vector<std::size_t>& at);

/// The plan that the results are of; nullopt where it is of another version of cdb, which is shown
/// as far as it goes; its measured runs are those that are selected. A large plan takes seconds to
/// read, so that a thread keeps the last one. Throws StoreError.
std::optional<plan::Plan> ReadPlan(const store::ResultFile& file);

/// The detector of each cell. Without an axis of them the plan is asked, which is read once; where
/// it cannot be there are no names. Throws StoreError.
class CellDetectors {
 public:
  explicit CellDetectors(const store::ResultFile& file);
  /// Empty where nobody knows.
  std::string Of(const store::ResultFile::Cell& cell) const;

 private:
  const store::ResultFile& file_;
  const std::optional<std::size_t> axis_;
  std::map<std::string, std::string> by_run_;
};

}  // namespace cdb::statistics
