#include "runtime/report/cycle_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "runtime/report/figures.h"
#include "runtime/report/numbers.h"

namespace cdb::report {
namespace {

/// From the median absolute deviation to the standard deviation of a normal distribution; how many
/// of these a stall is away at least; and the part of all times that stalls may be.
constexpr double kDeviation = 1.4826, kFarOff = 5, kMostStalls = 0.05;

/// A cycle in the repeats that reached it, the fastest first, with the repeat.
using SortedCycle = std::vector<std::pair<double, std::size_t>>;

/// Of the values, each as often as `counts` says of its repeat; NaN where that is never.
double MedianOf(const SortedCycle& cycle, const std::vector<std::uint32_t>& counts) {
  std::size_t total = counts.size();  // what the counts of all repeats add up to
  if (cycle.size() < counts.size()) {
    total = 0;
    for (const auto& [time, repeat] : cycle) total += counts[repeat];
    if (total == 0) return kNone;
  }
  auto middle = cycle.begin();
  std::size_t seen = counts[middle->second];
  while (seen <= (total - 1) / 2) seen += counts[(++middle)->second];
  const double low = middle->first;
  if (seen > total / 2) return low;
  do ++middle;
  while (counts[middle->second] == 0);
  return (low + middle->first) / 2;
}

std::vector<SortedCycle> SortCycles(const std::vector<std::vector<double>>& repeats) {
  std::vector<SortedCycle> cycles;
  for (std::size_t r = 0; r < repeats.size(); ++r) {
    cycles.resize(std::max(cycles.size(), repeats[r].size()));
    for (std::size_t c = 0; c < repeats[r].size(); ++c) cycles[c].emplace_back(repeats[r][c], r);
  }
  for (SortedCycle& cycle : cycles) std::ranges::sort(cycle);
  return cycles;
}

/// Limits times far from `medians`, the time of each cycle (cycle_times.h).
void Winsorise(std::vector<SortedCycle>& cycles, const std::vector<double>& medians) {
  std::vector<double> distances;
  for (std::size_t c = 0; c < cycles.size(); ++c)
    for (const auto& [time, repeat] : cycles[c])
      if (medians[c] > 0) distances.push_back(std::fabs(time - medians[c]) / medians[c]);
  if (distances.empty()) return;
  std::ranges::sort(distances);
  const double limit = std::max(kFarOff * kDeviation * Percentile(distances, 0.5),
                                Percentile(distances, 1 - kMostStalls));
  for (std::size_t c = 0; c < cycles.size(); ++c)
    for (auto& [time, repeat] : cycles[c])
      time = std::clamp(time, medians[c] * (1 - limit), medians[c] * (1 + limit));
}

}  // namespace

PhaseTimes TimesOver(const std::vector<std::vector<double>>& repeats, const Bootstrap& bootstrap) {
  std::vector<SortedCycle> cycles = SortCycles(repeats);
  const auto over_cycles = [&](const std::vector<std::uint32_t>& counts) {
    std::vector<double> times;
    times.reserve(cycles.size());
    for (const SortedCycle& cycle : cycles) times.push_back(MedianOf(cycle, counts));
    return times;
  };
  PhaseTimes times;
  times.cycles = over_cycles(std::vector<std::uint32_t>(repeats.size(), 1));
  times.mean.value = Mean(times.cycles);
  times.mean.things = static_cast<std::size_t>(
      std::ranges::count_if(repeats, [](const auto& repeat) { return !repeat.empty(); }));
  Winsorise(cycles, times.cycles);
  for (const Draw& draw : bootstrap.draws())
    times.mean.drawn.push_back(Mean(over_cycles(draw.counts)));
  return times;
}

const PhaseTimes& CycleTimes::Of(const MeasuredPoint& point, measure::Phase phase) {
  const auto [found, is_new] = points_.try_emplace(point.at);
  if (is_new) {
    // All phases of a cell are in one block of the file, which is read once.
    std::array<std::vector<std::vector<double>>, measure::kPhaseCount> repeats;
    for (std::size_t i = 0; i < repeats.size(); ++i) repeats[i].resize(file_.repeats());
    for (const store::ResultFile::Cell& cell : point.cells)
      for (std::size_t i = 0; i < repeats.size(); ++i)
        repeats[i][cell.rep] = file_.ReadDuration(static_cast<measure::Phase>(i), cell);
    for (std::size_t i = 0; i < repeats.size(); ++i)
      found->second[i] = TimesOver(repeats[i], bootstrap_);
  }
  return found->second[measure::IndexOf(phase)];
}

std::string CycleTimes::IntervalName() const {
  if (bootstrap_.kind() == IntervalKind::kNone) return "";
  return bootstrap_.kind() == IntervalKind::kRange ? "range" : "95 % interval";
}

std::string CycleTimes::Statistic(bool pools) const {
  return fmt::format("  {}ean over {}",
                     bootstrap_.size() > 1 ? fmt::format("Median over {} repeats per cycle, then m",
                                                         bootstrap_.size())
                                           : "M",
                     pools ? "cycles and cells" : "cycles");
}

std::string CycleTimes::StatisticLine(bool pools) const { return Statistic(pools) + ".\n"; }

std::string CycleTimes::StatisticAndIntervalLine(bool pools) const {
  const char* interval = "; no interval: one repeat.\n";
  if (bootstrap_.kind() == IntervalKind::kRange) interval = "; range over all draws of repeats.\n";
  if (bootstrap_.kind() == IntervalKind::kInterval) interval = "; bootstrap over whole repeats.\n";
  return Statistic(pools) + interval;
}

std::string CycleTimes::IntervalLine(bool lacks_repeats) const {
  const char* lack = lacks_repeats ? " -: a repeat is missing or void." : "";
  switch (bootstrap_.kind()) {
    case IntervalKind::kNone:
      return "  No interval: one repeat.\n";
    case IntervalKind::kRange:
      return fmt::format(
          "  Over all draws of {} repeats; an interval of 95 % takes {} repeats.{}\n",
          bootstrap_.size(), Bootstrap::kLeastForInterval, lack);
    case IntervalKind::kInterval:
      break;
  }
  return fmt::format("  By bootstrap over the {} repeats, whole runs at a time.{}\n",
                     bootstrap_.size(), lack);
}

}  // namespace cdb::report
