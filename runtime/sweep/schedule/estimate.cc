#include "runtime/sweep/schedule/estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cdb::schedule {

void TimeEstimate::Fit::Add(double objects, double cycle_s) {
  const double u = std::log(objects);
  const double v = std::log(cycle_s);
  n += 1;
  x += u;
  y += v;
  xx += u * u;
  xy += u * v;
}

double TimeEstimate::Fit::CycleSeconds(double objects) const {
  const double spread = n * xx - x * x;
  // Runs of similar size do not determine the slope, and no detector is steeper than testing all
  // pairs.
  constexpr double kMinSpread = 0.01;
  const double slope =
      spread > kMinSpread * n * n ? std::clamp((n * xy - x * y) / spread, 0.0, 2.0) : 1.0;
  return std::exp(y / n + slope * (std::log(objects) - x / n));
}

TimeEstimate::TimeEstimate(const std::vector<const plan::Run*>& to_do) {
  for (const plan::Run* run : to_do) ++kinds_[KindOf(*run)].left;
}

TimeEstimate::Kind TimeEstimate::KindOf(const plan::Run& run) {
  const plan::WorldSettings& world = run.scene.world;
  const bool is_limited = world.WordOr("timeout").empty();
  return {std::string(world.WordOr("detector")),
          std::max(1.0, static_cast<double>(run.scene.ObjectCount())),
          static_cast<double>(world.Count("cycles") + world.Count("warmup")),
          is_limited ? world.Real("timeout") : std::numeric_limits<double>::infinity()};
}

void TimeEstimate::Ended(const plan::Run& run, std::optional<double> wall_s) {
  const Kind kind = KindOf(run);
  Times& times = kinds_[kind];
  if (times.left > 0) --times.left;
  if (!wall_s) return;
  ++times.ended;
  times.sum_s += *wall_s;
  constexpr double kShortest = 1e-9;  // s; keeps its logarithm finite
  const double cycle_s = std::max(*wall_s, kShortest) / kind.cycles;
  fits_[kind.detector].Add(kind.objects, cycle_s);
  all_.Add(kind.objects, cycle_s);
}

std::optional<double> TimeEstimate::Predict(const Kind& kind, const Times& times) const {
  if (times.ended > 0) return times.sum_s / static_cast<double>(times.ended);
  if (all_.n == 0) return std::nullopt;
  const auto fit = fits_.find(kind.detector);
  const Fit& best = fit != fits_.end() ? fit->second : all_;
  return std::min(best.CycleSeconds(kind.objects) * kind.cycles, kind.timeout_s);
}

std::optional<double> TimeEstimate::Predict(const plan::Run& run) const {
  const Kind kind = KindOf(run);
  const auto times = kinds_.find(kind);
  return Predict(kind, times != kinds_.end() ? times->second : Times());
}

std::optional<double> TimeEstimate::Left() const {
  double sum = 0;
  for (const auto& [kind, times] : kinds_) {
    if (times.left == 0) continue;
    const auto one = Predict(kind, times);
    if (!one) return std::nullopt;
    sum += *one * static_cast<double>(times.left);
  }
  return sum;
}

}  // namespace cdb::schedule
