#include "runtime/statistics/figures.h"

#include <algorithm>
#include <cmath>

#include "runtime/statistics/cells.h"
#include "runtime/statistics/numbers.h"

namespace cdb::statistics {

double Percentile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return kNone;
  const double place = p * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return std::lerp(sorted[low], sorted[high], place - static_cast<double>(low));
}

CellGroups GroupCells(const store::ResultFile& file) {
  CellGroups groups;
  for (const store::ResultFile::Cell& cell : AllCells(file)) {
    const store::Status status = file.ReadStatus(cell);
    if (status == store::Status::kSkipped) {
      ++groups.skipped;
    } else if (status == store::Status::kMissing) {
      ++groups.missing;
    } else if (const auto trouble = Trouble(file, cell)) {
      groups.bad.push_back({cell, *trouble});
    } else {
      const measure::Judgement judgement = file.ReadJudgement(cell);
      groups.good.push_back(cell);
      groups.verdicts[judgement.verdict].push_back({cell, judgement.first_bad_cycle});
    }
  }
  return groups;
}

}  // namespace cdb::statistics
