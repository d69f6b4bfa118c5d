// The cells of a results file, for summaries: which there are, where they stand, and by which
// detector.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan.h"
#include "runtime/store/store.h"

namespace cdb::runtime {

/// In grid order, repeats innermost.
std::vector<ResultFile::Cell> AllCells(const ResultFile& file);

/// `quantity 10, detector dbvt, rep 0`.
std::string PlaceText(const ResultFile& file, const ResultFile::Cell& cell);

/// What a shell takes to run the cell by itself: `cdb run crowd.cdb -b crowd --only 0123…`.
std::string OnlyCommand(const ResultFile& file, const ResultFile::Cell& cell);

/// The axis of detectors; nullopt where the file sweeps none.
std::optional<std::size_t> DetectorAxis(const ResultFile& file);

/// The plan that the results are of; nullopt where it is of another version of cdb, which is shown
/// as far as it goes. Throws StoreError.
std::optional<compiler::Plan> ReadPlan(const ResultFile& file);

/// The detector of each cell. Without an axis of them the plan is asked, which is read once; where
/// it cannot be there are no names. Throws StoreError.
class CellDetectors {
 public:
  explicit CellDetectors(const ResultFile& file);
  /// Empty where nobody knows.
  std::string Of(const ResultFile::Cell& cell) const;

 private:
  const ResultFile& file_;
  const std::optional<std::size_t> axis_;
  std::map<std::string, std::string> by_run_;
};

}  // namespace cdb::runtime
