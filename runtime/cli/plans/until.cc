#include "runtime/cli/plans/until.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "runtime/cli/options/exit_status.h"
#include "runtime/figures/model.h"
#include "runtime/protocol/series.h"

namespace cdb::plans {

bool Precision::IsWholeRound() const {
  return repeats >= figures::Bootstrap::kLeastForInterval && missing == 0;
}

Precision PrecisionOf(const results::ResultFile& file, double wanted) {
  const figures::Model model(file, {.only_sound = true});
  Precision precision;
  precision.repeats = file.begun_repeats();
  for (const results::ResultFile::Cell& cell : figures::AllCells(file))
    precision.missing +=
        cell.rep < precision.repeats && file.ReadStatus(cell) == results::Status::kMissing;
  for (const figures::MeasuredPoint& point : model.points()) {
    const figures::Estimate& step = model.TimeOf(point, protocol::Phase::kStep);
    const figures::Interval interval = model.times().IntervalOf(step);
    const double half = std::max(interval.high - step.value, step.value - interval.low);
    if (!std::isfinite(half) || !(step.value > 0)) continue;
    ++precision.points;
    precision.within += half <= wanted * step.value;
    precision.widest = std::max(precision.widest, half / step.value);
  }
  return precision;
}

std::uint64_t NextRepeats(const Precision& reached, double wanted, std::uint64_t most) {
  if (reached.IsReached()) return reached.repeats;
  const double ratio = reached.widest / wanted;
  const auto repeats = static_cast<double>(reached.repeats);
  const double needed = std::clamp(std::ceil(repeats * ratio * ratio), repeats + 1, 2 * repeats);
  return std::min(static_cast<std::uint64_t>(needed), std::max(most, reached.repeats));
}

std::string Describe(const Precision& reached, double wanted) {
  const std::string head = fmt::format("{} repeats: ", reached.repeats);
  if (reached.points == 0) return head + "no point has an interval, as runs are missing or void";
  if (reached.IsReached())
    return head + fmt::format("every mean step is known within {:.3g} %", 100 * wanted);
  return head +
         fmt::format("{} of {} mean steps are known within {:.3g} %, the worst within {:.3g} %",
                     reached.within, reached.points, 100 * wanted, 100 * reached.widest);
}

void CheckUntil(const plan::Plan& plan) {
  if (!plan.Records("timing"))
    throw options::CommandError(
        fmt::format("--until: '{}' records no times; add timing to `record`", plan.benchmark));
  if (plan.repeats <= figures::Bootstrap::kLeastForInterval)
    throw options::CommandError(
        fmt::format("--until: '{}' has repeats {}, the upper limit, but an interval needs {}; "
                    "write more, such as repeats 50",
                    plan.benchmark, plan.repeats, figures::Bootstrap::kLeastForInterval));
}

}  // namespace cdb::plans
