#include "runtime/protocol/machine/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace cdb::machine {
namespace {

/// The system counts in ticks, so a short run may be off by one or two of them.
constexpr double kTicksNs = 30e6;
constexpr double kLongPauses = 2, kEvenSteps = 1.5;

/// The mean over the median if nine in ten steps are alike; else 1.
double PauseRatio(std::span<const double> steps) {
  std::vector<double> sorted;
  std::ranges::copy_if(steps, std::back_inserter(sorted), [](double ns) { return ns > 0; });
  if (sorted.size() < 10) return 1;
  std::ranges::sort(sorted);
  const double median = sorted[sorted.size() / 2];
  if (sorted[sorted.size() * 9 / 10] > kEvenSteps * median) return 1;
  return std::accumulate(sorted.begin(), sorted.end(), 0.0) /
         (median * static_cast<double>(sorted.size()));
}

}  // namespace

std::span<const std::string_view> NoiseNames() {
  static constexpr std::string_view kNames[] = {"unknown", "quiet", "noisy"};
  return kNames;
}

bool NoiseJudgement::IsQuieterThan(const NoiseJudgement& other) const {
  if (noise == Noise::kUnknown || other.noise == Noise::kUnknown)
    return other.noise == Noise::kUnknown && noise != Noise::kUnknown;
  return noise == other.noise ? disturbed < other.disturbed : noise == Noise::kQuiet;
}

NoiseJudgement JudgeNoise(const schema::RunScalars& scalars, MachineLoad machine,
                          std::uint64_t threads, std::span<const double> steps) {
  if (!(scalars.cycles_wall_ns > 0)) return {};
  std::string why;
  const auto add = [&why](const std::string& cause) { why += (why.empty() ? "" : ", ") + cause; };
  const double off = 1 - scalars.cycles_cpu_ns / scalars.cycles_wall_ns;
  if (threads == 1 && off > kMostOffProcessor)
    add(fmt::format("{:.0f} % of the time not on a processor", 100 * off));
  const double stolen = scalars.stolen_ns / scalars.cycles_wall_ns;
  if (stolen > kMostStolen)
    add(fmt::format("{:.0f} % stolen by other virtual machines", 100 * stolen));
  const double others = scalars.others_ns / scalars.cycles_wall_ns;
  if (scalars.others_ns - kTicksNs > kMostOthers * scalars.cycles_wall_ns)
    add(fmt::format("other programs on {:.2f} processors", others));
  if (machine.load > machine.processors)
    add(fmt::format("load {:.1f} on {:.0f} processor{}", machine.load, machine.processors,
                    machine.processors == 1 ? "" : "s"));
  if (const double ratio = PauseRatio(steps); ratio > kLongPauses)
    add(fmt::format("a few long pauses: the mean step is {:.1f} medians", ratio));
  const double disturbed = std::max({0.0, threads == 1 ? off : 0.0, stolen, std::min(others, 1.0)});
  return {why.empty() ? Noise::kQuiet : Noise::kNoisy, why, disturbed};
}

}  // namespace cdb::machine
