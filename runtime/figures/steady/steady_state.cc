#include "runtime/figures/steady/steady_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/figures/history/change_points.h"
#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::steady {
namespace {

double MeanOf(std::span<const double> values) {
  return figures::Mean({values.begin(), values.end()});
}

}  // namespace

SteadyState FindSteadyState(std::span<const double> cycles) {
  SteadyState steady;
  if (cycles.size() < kLeastCycles) return steady;
  const std::size_t length = (cycles.size() + kMostParts - 1) / kMostParts;
  std::vector<double> logs;
  for (std::size_t from = 0; from < cycles.size(); from += length) {
    const auto part = cycles.subspan(from, std::min(length, cycles.size() - from));
    logs.push_back(std::log(figures::Median({part.begin(), part.end()})));
  }
  const std::vector<history::Change> changes =
      history::FindChanges(logs, {.least_effect = kLeastChange});
  steady.all = MeanOf(cycles);
  if (!changes.empty()) steady.warmup = changes.back().to * length;
  steady.state = steady.warmup == 0                   ? State::kFromStart
                 : 2 * steady.warmup <= cycles.size() ? State::kAfterWarmup
                                                      : State::kNever;
  if (steady.state != State::kNever) steady.rest = MeanOf(cycles.subspan(steady.warmup));
  return steady;
}

std::vector<PointState> FindSteadyStates(const figures::Model& model) {
  std::vector<PointState> all;
  if (!model.HasTimes() || model.points().size() > kMostPoints) return all;
  for (const figures::MeasuredPoint& point : model.points()) {
    if (!point.IsSound()) continue;
    const std::vector<double>& cycles = model.times().Of(point, protocol::Phase::kStep).cycles;
    if (std::ranges::all_of(cycles, [](double time) { return std::isfinite(time) && time > 0; }))
      all.push_back({&point, FindSteadyState(cycles)});
  }
  return all;
}

std::string_view StateName(State state) {
  constexpr std::string_view kNames[] = {"too_short", "from_start", "after_warmup", "never"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string SteadyText(const std::vector<PointState>& states) {
  std::size_t from_start = 0, never = 0, all = 0, longest = 0;
  std::vector<double> ratios;
  for (const PointState& of : states) {
    const SteadyState& steady = of.steady;
    if (steady.state == State::kTooShort) continue;
    ++all;
    from_start += steady.state == State::kFromStart;
    never += steady.state == State::kNever;
    if (steady.state != State::kAfterWarmup) continue;
    longest = std::max(longest, steady.warmup);
    ratios.push_back(steady.rest / steady.all);
  }
  if (all == 0) return {};
  if (from_start == all) return "The time of a step is steady from the first cycle on.";
  const auto where = [all](std::size_t count) {
    return count == all ? std::string() : fmt::format(" in {} of {} points", count, all);
  };
  std::string text;
  if (!ratios.empty()) {
    const auto [least, most] = std::ranges::minmax(ratios);
    const std::string low = terminal::ShortNumber(least), high = terminal::ShortNumber(most);
    text = fmt::format(
        "The time of a step is steady after at most {} cycles{}: the rest takes {} of the mean of "
        "all. `warmup {}` leaves the transient out.",
        longest, where(ratios.size()), low == high ? low : fmt::format("{} to {}", low, high),
        longest);
  }
  if (never > 0)
    text += fmt::format(
        "{}The time of a step still changes in the second half of the cycles{}: a mean is over the "
        "stages of the scene, and no warm-up makes it steady.",
        text.empty() ? "" : " ", where(never));
  return text;
}

}  // namespace cdb::steady
