#include "runtime/figures/times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "compiler/plan/requirement.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// The factor from the median absolute deviation to the standard deviation of a normal
/// distribution; the least distance of a stall in these; and the largest fraction of all times that
/// may be stalls.
constexpr double kDeviation = 1.4826, kFarOff = 5, kMostStalls = 0.05;

/// The time of a cycle in a repeat.
using TimedRepeat = std::pair<double, std::size_t>;
/// A cycle in the repeats that reached it, the fastest first.
using SortedCycle = std::span<const TimedRepeat>;

/// Cycles, one after the other.
class SortedCycles {
 public:
  explicit SortedCycles(const std::vector<std::vector<double>>& repeats) {
    std::size_t cycles = 0, all = 0;
    for (const std::vector<double>& repeat : repeats) {
      cycles = std::max(cycles, repeat.size());
      all += repeat.size();
    }
    times_.reserve(all);
    for (std::size_t c = 0; c < cycles; ++c) {
      begins_.push_back(times_.size());
      for (std::size_t r = 0; r < repeats.size(); ++r)
        if (c < repeats[r].size()) times_.emplace_back(repeats[r][c], r);
      std::sort(times_.begin() + static_cast<std::ptrdiff_t>(begins_.back()), times_.end());
    }
    begins_.push_back(times_.size());
  }

  std::size_t size() const { return begins_.size() - 1; }
  SortedCycle operator[](std::size_t cycle) const {
    return std::span(times_).subspan(begins_[cycle], begins_[cycle + 1] - begins_[cycle]);
  }
  std::span<TimedRepeat> At(std::size_t cycle) {
    return std::span(times_).subspan(begins_[cycle], begins_[cycle + 1] - begins_[cycle]);
  }
  std::size_t time_count() const { return times_.size(); }

 private:
  std::vector<TimedRepeat> times_;
  std::vector<std::size_t> begins_;  ///< for each cycle, and the end
};

/// The indices of the two middle values of a sorted list in which each counts as often as its
/// repeat; equal if the number is odd. Nullopt for an empty list.
std::optional<std::pair<std::size_t, std::size_t>> MiddleOf(
    SortedCycle cycle, const std::vector<std::uint32_t>& counts) {
  std::size_t total = counts.size();  // sum of the counts of all repeats
  if (cycle.size() < counts.size()) {
    total = 0;
    for (const auto& [time, repeat] : cycle) total += counts[repeat];
    if (total == 0) return std::nullopt;
  }
  std::size_t middle = 0;
  std::size_t seen = counts[cycle[0].second];
  while (seen <= (total - 1) / 2) seen += counts[cycle[++middle].second];
  const std::size_t low = middle;
  if (seen > total / 2) return std::pair{low, low};
  do ++middle;
  while (counts[cycle[middle].second] == 0);
  return std::pair{low, middle};
}

/// The median of the values, each counted as often as `counts` says for its repeat; NaN if there
/// are none.
double MedianOf(SortedCycle cycle, const std::vector<std::uint32_t>& counts) {
  const auto middle = MiddleOf(cycle, counts);
  if (!middle) return kNone;
  const auto [low, high] = *middle;
  return low == high ? cycle[low].first : (cycle[low].first + cycle[high].first) / 2;
}

/// The least of `chosen` values, in the mean over all choices of that many. Each value counts as
/// often as `counts` says for its repeat. NaN if there are none.
double FastestOfChosen(SortedCycle cycle, const std::vector<std::uint32_t>& counts,
                       std::size_t chosen) {
  std::size_t total = 0;
  for (const auto& [time, repeat] : cycle) total += counts[repeat];
  if (total == 0) return kNone;
  chosen = std::min(chosen, total);
  double mean = 0,
         above = 1;  // the fraction of the choices among the remaining values
  std::size_t left = total;
  for (const auto& [time, repeat] : cycle) {
    double still = above;
    for (std::uint32_t i = 0; i < counts[repeat]; ++i, --left)
      still *= left > chosen ? static_cast<double>(left - chosen) / static_cast<double>(left) : 0;
    mean += (above - still) * time;
    if (still == 0) break;
    above = still;
  }
  return mean;
}

/// Cycles in which the repeats have the same order. Their median is at the same index in every
/// draw, so the mean over all of them does not need each cycle.
struct AlikeCycles {
  SortedCycle first;
  std::vector<double> sums;  ///< of the times at each index in the order
};

/// Nullopt if a repeat is missing in some cycle, or if there are so many repeats that few cycles
/// share an order.
std::optional<std::vector<AlikeCycles>> GroupAlike(const SortedCycles& cycles,
                                                   std::size_t repeats) {
  constexpr std::size_t kMostRepeats = 6;
  if (repeats > kMostRepeats || cycles.time_count() != repeats * cycles.size()) return std::nullopt;
  std::vector<AlikeCycles> groups;
  std::map<std::uint64_t, std::size_t> places;  // by the order of the repeats
  for (std::size_t c = 0; c < cycles.size(); ++c) {
    std::uint64_t order = 0;
    for (const auto& [time, repeat] : cycles[c]) order = order * kMostRepeats + repeat;
    const auto [place, is_new] = places.try_emplace(order, groups.size());
    if (is_new) groups.push_back({cycles[c], std::vector<double>(repeats, 0)});
    for (std::size_t i = 0; i < repeats; ++i) groups[place->second].sums[i] += cycles[c][i].first;
  }
  return groups;
}

/// The mean over the cycles of their medians in a draw.
double MeanOfMedians(const std::vector<AlikeCycles>& groups, std::size_t cycles,
                     const std::vector<std::uint32_t>& counts) {
  double sum = 0;
  for (const AlikeCycles& group : groups) {
    const auto [low, high] = *MiddleOf(group.first, counts);
    sum += low == high ? group.sums[low] : (group.sums[low] + group.sums[high]) / 2;
  }
  return sum / static_cast<double>(cycles);
}

/// Percentile of values in any order; reorders them.
double PercentileOf(std::vector<double>& values, double p) {
  const double place = p * static_cast<double>(values.size() - 1);
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), low, values.end());
  const auto high = low + 1 == values.end() ? low : std::min_element(low + 1, values.end());
  return std::lerp(*low, *high, place - std::floor(place));
}

/// Limits times far from `typical`, the time of each cycle (times.h).
void Winsorise(SortedCycles& cycles, const std::vector<double>& typical) {
  std::vector<double> distances;
  distances.reserve(cycles.time_count());
  for (std::size_t c = 0; c < cycles.size(); ++c)
    for (const auto& [time, repeat] : cycles[c])
      if (typical[c] > 0) distances.push_back(std::fabs(time - typical[c]) / typical[c]);
  if (distances.empty()) return;
  const double limit = std::max(kFarOff * kDeviation * PercentileOf(distances, 0.5),
                                PercentileOf(distances, 1 - kMostStalls));
  for (std::size_t c = 0; c < cycles.size(); ++c)
    for (auto& [time, repeat] : cycles.At(c))
      time = std::clamp(time, typical[c] * (1 - limit), typical[c] * (1 + limit));
}

constexpr std::string_view kStatisticHeads[] = {
    "Mean",    "Median",  "5th percentile", "95th percentile", "99th percentile",
    "Minimum", "Maximum", "Worst"};

/// The longest cycle of the repeats, and of the repeats in each draw.
Estimate WorstOf(const std::vector<std::vector<double>>& repeats, const Bootstrap& bootstrap) {
  std::vector<double> longest;
  for (const std::vector<double>& repeat : repeats)
    longest.push_back(repeat.empty() ? kNone : std::ranges::max(repeat));
  Estimate worst = {kNone, {}};
  for (const double time : longest) worst.value = std::fmax(worst.value, time);
  for (const Draw& draw : bootstrap.draws()) {
    double most = kNone;
    for (std::size_t r = 0; r < longest.size(); ++r)
      if (draw.counts[r] > 0) most = std::fmax(most, longest[r]);
    worst.drawn.push_back(most);
  }
  return worst;
}

}  // namespace

std::string PhaseName(protocol::Phase phase) {
  return std::string(protocol::PhaseNames()[protocol::IndexOf(phase)]);
}

std::vector<protocol::Phase> AllPhases() {
  std::vector<protocol::Phase> phases;
  for (std::size_t i = 0; i < protocol::kPhaseCount; ++i)
    phases.push_back(static_cast<protocol::Phase>(i));
  return phases;
}

double StatisticOf(std::vector<double> values, CycleStatistic statistic) {
  if (values.empty() || std::ranges::any_of(values, [](double value) { return std::isnan(value); }))
    return kNone;
  const auto percentile = [&values](double p) {
    std::ranges::sort(values);
    return Percentile(values, p);
  };
  switch (statistic) {
    case CycleStatistic::kMean:
      return Mean(values);
    case CycleStatistic::kMedian:
      return percentile(0.5);
    case CycleStatistic::kP5:
      return percentile(0.05);
    case CycleStatistic::kP95:
      return percentile(0.95);
    case CycleStatistic::kP99:
      return percentile(0.99);
    case CycleStatistic::kMin:
      return std::ranges::min(values);
    case CycleStatistic::kMax:
    case CycleStatistic::kWorst:
      break;
  }
  return std::ranges::max(values);
}

std::span<const std::string_view> CycleStatisticNames() { return plan::kCycleStatistics; }

PhaseTimes TimesOver(const std::vector<std::vector<double>>& repeats, const Bootstrap& bootstrap,
                     CycleStatistic statistic, std::optional<std::size_t> fastest_of) {
  SortedCycles cycles(repeats);
  const auto over_cycles = [&](const std::vector<std::uint32_t>& counts) {
    std::vector<double> times;
    times.reserve(cycles.size());
    for (std::size_t c = 0; c < cycles.size(); ++c)
      times.push_back(fastest_of ? FastestOfChosen(cycles[c], counts, *fastest_of)
                                 : MedianOf(cycles[c], counts));
    return times;
  };
  PhaseTimes times;
  times.cycles = over_cycles(std::vector<std::uint32_t>(repeats.size(), 1));
  times.mean.value = Mean(times.cycles);
  for (const std::vector<double>& repeat : repeats) times.repeat_means.push_back(Mean(repeat));
  times.mean.things = static_cast<std::size_t>(
      std::ranges::count_if(repeats, [](const auto& repeat) { return !repeat.empty(); }));
  const bool is_other = statistic != CycleStatistic::kMean;
  if (is_other) times.other.value = StatisticOf(times.cycles, statistic);
  if (!bootstrap.draws().empty()) Winsorise(cycles, times.cycles);
  const auto alike = is_other || fastest_of ? std::nullopt : GroupAlike(cycles, repeats.size());
  for (const Draw& draw : bootstrap.draws()) {
    if (alike) {
      times.mean.drawn.push_back(MeanOfMedians(*alike, cycles.size(), draw.counts));
      continue;
    }
    const std::vector<double> drawn = over_cycles(draw.counts);
    times.mean.drawn.push_back(Mean(drawn));
    if (is_other) times.other.drawn.push_back(StatisticOf(drawn, statistic));
  }
  if (statistic == CycleStatistic::kWorst) times.other = WorstOf(repeats, bootstrap);
  times.other.things = times.mean.things;
  return times;
}

std::size_t FastestOf(std::size_t repeats) {
  const double few = std::floor(2 * std::sqrt(static_cast<double>(repeats)));
  return std::min(repeats, static_cast<std::size_t>(few));
}

const PhaseTimes& CycleTimes::Of(const MeasuredPoint& point, protocol::Phase phase) {
  const auto [found, is_new] = points_.try_emplace(point.at);
  if (is_new) {
    // All phases of a cell are in one block of the file, which is read once.
    std::array<std::vector<std::vector<double>>, protocol::kPhaseCount> repeats;
    for (std::size_t i = 0; i < repeats.size(); ++i) repeats[i].resize(bootstrap_.size());
    for (const results::ResultFile::Cell& cell : point.cells)
      for (std::size_t i = 0; i < repeats.size(); ++i)
        repeats[i][cell.rep] = file_.ReadDuration(static_cast<protocol::Phase>(i), cell);
    for (std::size_t i = 0; i < repeats.size(); ++i)
      found->second[i] = TimesOver(repeats[i], bootstrap_, statistic_, fastest_of_);
  }
  return found->second[protocol::IndexOf(phase)];
}

const Estimate& CycleTimes::FigureOf(const MeasuredPoint& point, protocol::Phase phase) {
  const PhaseTimes& times = Of(point, phase);
  return statistic_ == CycleStatistic::kMean ? times.mean : times.other;
}

double CycleTimes::StatisticOf(const MeasuredPoint& point, protocol::Phase phase,
                               CycleStatistic statistic) {
  return figures::StatisticOf(Of(point, phase).cycles, statistic);
}

std::string_view CycleTimes::StatisticName() const {
  return plan::kCycleStatistics[static_cast<std::size_t>(statistic_)];
}

std::string_view CycleTimes::StatisticHead() const {
  return kStatisticHeads[static_cast<std::size_t>(statistic_)];
}

std::string CycleTimes::Statistic(bool pools) const {
  if (statistic_ == CycleStatistic::kWorst)
    return fmt::format(
        "Longest cycle of {}, disturbances included{}",
        bootstrap_.size() > 1 ? fmt::format("any of {} repeats", bootstrap_.size()) : "the run",
        pools ? ", then mean over cells" : "");
  std::string over = std::string(StatisticName()) + " over cycles";
  if (statistic_ == CycleStatistic::kMean && pools) over += " and cells";
  if (statistic_ != CycleStatistic::kMean && pools) over += ", then mean over cells";
  if (bootstrap_.size() > 1)
    return fmt::format("Median over {} repeats per cycle, then {}", bootstrap_.size(), over);
  over[0] = static_cast<char>(std::toupper(over[0]));
  return over;
}

std::string CycleTimes::StatisticNote(bool pools) const { return Statistic(pools) + "."; }

std::string CycleTimes::StatisticAndIntervalNote(bool pools) const {
  const char* interval = "; no interval: one repeat.";
  if (bootstrap_.kind() == IntervalKind::kRange) interval = "; range over all draws of repeats.";
  if (bootstrap_.kind() == IntervalKind::kInterval) interval = "; bootstrap over whole repeats.";
  return Statistic(pools) + interval;
}

std::string CycleTimes::IntervalNote(bool lacks_repeats) const {
  const char* lack = lacks_repeats ? " -: a repeat is missing or void." : "";
  switch (bootstrap_.kind()) {
    case IntervalKind::kAbsent:
      return "No interval: one repeat.";
    case IntervalKind::kRange:
      return fmt::format("Range over all draws of {} repeats; a 95 % interval needs {} repeats.{}",
                         bootstrap_.size(), Bootstrap::kLeastForInterval, lack);
    case IntervalKind::kInterval:
      break;
  }
  return fmt::format("By bootstrap over the {} repeats, whole runs at a time.{}", bootstrap_.size(),
                     lack);
}

std::string JoinWords(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

std::string IntervalNote(const CycleTimes& times, const Estimate& estimate, double scale) {
  const Interval interval = times.IntervalOf(estimate);
  if (std::isnan(interval.low) || std::isnan(interval.high)) return {};
  return fmt::format(" ({} {})", times.IntervalName(),
                     IntervalText({interval.low * scale, interval.high * scale}));
}

std::string TimeText(double ns) {
  const terminal::TimeUnit unit = terminal::TimeUnit::For(ns);
  return fmt::format("{} {}", terminal::ShortNumber(ns / unit.ns), unit.name);
}

std::vector<std::size_t> OtherAxes(const results::ResultFile& file, std::size_t axis) {
  std::vector<std::size_t> others = AllAxes(file);
  std::erase(others, axis);
  return others;
}

std::string AxisWords(const plan::Axis& axis) {
  if (axis.parameter == "objects.quantity" && axis.name == "quantity")
    return "the number of objects";
  std::string words = axis.name;
  std::ranges::replace(words, '_', ' ');
  return words;
}

}  // namespace cdb::figures
