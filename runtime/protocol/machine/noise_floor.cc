#include "runtime/protocol/machine/noise_floor.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include "runtime/protocol/machine/host.h"
#include "runtime/protocol/machine/noise.h"

namespace cdb::machine {
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
