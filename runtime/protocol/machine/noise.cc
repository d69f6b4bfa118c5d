#include "runtime/protocol/machine/noise.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "runtime/protocol/machine/machine.h"

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

namespace {

using Clock = std::chrono::steady_clock;

double Now() {
  return std::chrono::duration<double, std::nano>(Clock::now().time_since_epoch()).count();
}

double ProcessorTimeOfThread() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e9 + static_cast<double>(time.tv_nsec);
}

/// Marsaglia's xorshift: each step depends on the one before, so nothing can be optimised away.
std::uint64_t Work(std::uint64_t state, int steps) {
  for (int i = 0; i < steps; ++i) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
  }
  return state;
}

double CostOfClock() {
  constexpr int kReadings = 10'000;
  const double begin = Now();
  for (int i = 0; i < kReadings; ++i) static_cast<void>(Now());
  return (Now() - begin) / (kReadings + 1);
}

}  // namespace

bool NoiseFloor::IsQuiet() const {
  return half_high - half_low <= 0.02 * median && p99 <= 1.1 * median &&
         off_processor <= kMostOffProcessor && !(stolen > kMostStolen) && !(others > kMostOthers);
}

NoiseFloor MeasureNoiseFloor(double seconds) {
  constexpr int kSteps = 250'000;
  NoiseFloor floor;
  floor.clock_ns = CostOfClock();
  volatile std::uint64_t state = 88172645463325252ULL;
  state = Work(state, kSteps);  // warm-up, until the processor runs at speed
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(seconds * 1e4) + 1);
  const TimeOfAllProcessors before = ReadTimeOfAllProcessors();
  const double begin = Now(), used = ProcessorTimeOfThread();
  double last = begin;
  while (last - begin < seconds * 1e9 || times.empty()) {
    state = Work(state, kSteps);
    const double now = Now();
    times.push_back(now - last);
    last = now;
  }
  const double wall = last - begin;
  const double own = ProcessorTimeOfThread() - used;
  const TimeOfAllProcessors after = ReadTimeOfAllProcessors();
  floor.off_processor = std::max(0.0, 1 - own / wall);
  floor.stolen = (after.stolen - before.stolen) / wall;
  floor.others = std::max(0.0, (after.busy - before.busy - own) / wall);
  std::ranges::sort(times);
  const auto at = [&](double part) {
    return times[static_cast<std::size_t>(part * static_cast<double>(times.size() - 1))];
  };
  floor.loops = times.size();
  floor.median = at(0.5);
  floor.half_low = at(0.25);
  floor.half_high = at(0.75);
  floor.p99 = at(0.99);
  floor.worst = times.back();
  return floor;
}

}  // namespace cdb::machine
