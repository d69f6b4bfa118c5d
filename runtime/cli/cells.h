// The cells of a results file, for summaries: which there are, where they stand, and by which
// detector.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::runtime {

/// In grid order, repeats innermost.
std::vector<ResultFile::Cell> AllCells(const ResultFile& file);

/// `quantity 10, detector dbvt, rep 0`.
std::string PlaceText(const ResultFile& file, const ResultFile::Cell& cell);

/// The axis of detectors; nullopt where the file sweeps none.
std::optional<std::size_t> DetectorAxis(const ResultFile& file);

/// The detector of each cell. Without an axis of them the plan is asked, which is read once; where
/// it is of another version there are no names. Throws StoreError.
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
