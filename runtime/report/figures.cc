#include "runtime/report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "compiler/plan/pruning.h"
#include "compiler/schema/schema.h"
#include "runtime/report/cells.h"
#include "runtime/report/numbers.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;

Point Without(Point at, std::size_t axis) {
  at.erase(at.begin() + static_cast<std::ptrdiff_t>(axis));
  return at;
}

void Sort(Pool& pool) {
  for (auto& phase : pool.phases) std::ranges::sort(phase);
  std::ranges::sort(pool.pairs);
  std::ranges::sort(pool.contacts);
}

/// Some of `cells` left the component out, and others kept it.
bool AreUnlike(const store::ResultFile& file, const std::vector<const Cell*>& cells,
               const schema::ComponentInfo& info) {
  const auto left_out = [&](const Cell* cell) {
    return schema::ListsWord(file.ReadText("omitted", *cell), info.name);
  };
  const auto kept = [&](const Cell* cell) {
    return plan::SaysKept(file.ReadText("needs", *cell), info.component);
  };
  return info.IsVisible() && std::ranges::any_of(cells, left_out) &&
         std::ranges::any_of(cells, kept);
}

}  // namespace

double Percentile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return kNone;
  const double place = p * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return std::lerp(sorted[low], sorted[high], place - static_cast<double>(low));
}

CellGroups GroupCells(const store::ResultFile& file) {
  CellGroups groups;
  for (const Cell& cell : AllCells(file)) {
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

std::map<Point, Pool> PoolCells(const store::ResultFile& file, const std::vector<Cell>& cells,
                                const std::vector<std::size_t>& by) {
  std::map<Point, Pool> pools;
  for (const Cell& cell : cells) {
    Point key;
    for (const std::size_t axis : by) key.push_back(cell.at[axis]);
    Pool& pool = pools[key];
    if (file.Has("duration"))
      for (std::size_t phase = 0; phase < measure::kPhaseCount; ++phase)
        Append(pool.phases[phase], file.ReadDuration(static_cast<measure::Phase>(phase), cell));
    if (file.Has("pairs")) Append(pool.pairs, file.ReadSeries("pairs", cell));
    if (file.Has("contacts")) Append(pool.contacts, file.ReadSeries("contacts", cell));
  }
  for (auto& [key, pool] : pools) Sort(pool);
  return pools;
}

DetectorMedians MediansByDetector(const store::ResultFile& file, const std::vector<Cell>& cells,
                                  std::size_t detector_axis, measure::Phase phase) {
  DetectorMedians points;
  for (const Cell& cell : cells) {
    std::vector<double>& medians = points[{Without(cell.at, detector_axis), cell.rep}];
    medians.resize(file.axes()[detector_axis].values.size(), kNone);
    auto values = file.ReadDuration(phase, cell);
    std::ranges::sort(values);
    medians[cell.at[detector_axis]] = Percentile(values, 0.5);
  }
  return points;
}

UnlikeOmissions FindUnlikeOmissions(const store::ResultFile& file, const std::vector<Cell>& cells,
                                    std::size_t detector_axis) {
  if (!file.Has("omitted") || !file.Has("needs")) return {};
  std::map<ComparedPoint, std::vector<const Cell*>> points;
  for (const Cell& cell : cells)
    points[{Without(cell.at, detector_axis), cell.rep}].push_back(&cell);
  UnlikeOmissions found;
  found.points = points.size();
  std::vector<bool> unlike(schema::Components().size());
  for (const auto& [key, compared] : points) {
    bool is_unlike = false;
    for (std::size_t i = 0; i < unlike.size(); ++i) {
      if (!AreUnlike(file, compared, schema::Components()[i])) continue;
      unlike[i] = is_unlike = true;
    }
    found.unlike_points += is_unlike ? 1 : 0;
  }
  for (std::size_t i = 0; i < unlike.size(); ++i)
    if (unlike[i]) found.components.emplace_back(schema::Components()[i].name);
  return found;
}

double GeometricMean(const std::vector<double>& values) {
  double log = 0;
  for (const double value : values) log += std::log(value);
  return std::exp(log / static_cast<double>(values.size()));
}

}  // namespace cdb::report
