// The times of single cycles, for results documents of a page.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "runtime/figures/bootstrap.h"
#include "runtime/printers/json_parts.h"

namespace cdb::printers {
namespace {

using protocol::Phase;

constexpr std::size_t kMaxBins = 200, kMaxTimelines = 60;
constexpr std::size_t kMaxDistributions = 500, kMaxStepDistributions = 2000;
constexpr int kPercents[] = {0, 5, 10, 20, 25, 30, 40, 50, 60, 70, 75, 80, 90, 95, 100};
constexpr int kDigits = 4;  // more than a screen can show

/// The points whose cycles are drawn: the same number for each detector.
std::vector<std::size_t> ChooseTimelines(const figures::Model& model) {
  const auto axis = model.detector_axis();
  const std::size_t detectors = axis ? model.axis(*axis).values.size() : 1;
  const std::size_t each = model.grid().size() <= kMaxTimelines
                               ? model.grid().size()
                               : std::max<std::size_t>(1, kMaxTimelines / detectors);
  std::map<std::size_t, std::size_t> taken;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < model.grid().size() && chosen.size() < kMaxTimelines; ++i) {
    const figures::GridPoint& point = model.grid()[i];
    if (point.measured != nullptr && ++taken[axis ? point.at[*axis] : 0] <= each)
      chosen.push_back(i);
  }
  return chosen;
}

/// The begin and end of each bin.
std::vector<std::pair<std::size_t, std::size_t>> BinsOf(std::uint64_t cycles) {
  const std::size_t count = std::min<std::size_t>(cycles, kMaxBins);
  std::vector<std::pair<std::size_t, std::size_t>> bins;
  for (std::size_t i = 0; i < count; ++i)
    bins.emplace_back(i * cycles / count, (i + 1) * cycles / count);
  return bins;
}

/// The mean of each bin over the cycles that ran; null if none did.
Json Binned(const std::vector<double>& cycles,
            const std::vector<std::pair<std::size_t, std::size_t>>& bins) {
  return JsonColumn(bins.size(), [&](std::size_t i) {
    double sum = 0, count = 0;
    for (std::size_t c = bins[i].first; c < std::min(bins[i].second, cycles.size()); ++c) {
      if (std::isnan(cycles[c])) continue;
      sum += cycles[c];
      ++count;
    }
    return JsonNumber(sum / count, kDigits);
  });
}

Json QuantilesOf(std::vector<double> cycles) {
  std::erase_if(cycles, [](double time) { return std::isnan(time); });
  std::ranges::sort(cycles);
  return JsonColumn(std::size(kPercents), [&](std::size_t i) {
    return JsonNumber(figures::Percentile(cycles, kPercents[i] / 100.0), kDigits);
  });
}

/// The mean over the cycles, for each repeat of a point.
Json RepeatMeans(const results::ResultFile& file, const figures::MeasuredPoint& point,
                 Phase phase) {
  Json means = Json::array();
  for (const figures::Cell& cell : point.cells)
    means.push_back(JsonNumber(figures::Mean(file.ReadDuration(phase, cell)), kDigits));
  return means;
}

}  // namespace

Json DocumentCycles(const figures::Model& model) {
  if (!model.HasTimes() || IsLarge(model)) return nullptr;
  const std::vector<std::size_t> chosen = ChooseTimelines(model);
  // Cycles that ran; the file has room for more.
  std::size_t cycles = 0;
  for (const std::size_t i : chosen)
    cycles =
        std::max(cycles, model.times().Of(*model.grid()[i].measured, Phase::kStep).cycles.size());
  const auto bins = BinsOf(cycles);
  Json all = {{"points", chosen}, {"of", model.points().size()}, {"bins", bins}};
  for (const Phase phase : figures::AllPhases())
    all[figures::PhaseName(phase)] = JsonColumn(chosen.size(), [&](std::size_t i) {
      return Binned(model.times().Of(*model.grid()[chosen[i]].measured, phase).cycles, bins);
    });
  return all;
}

Json DocumentDistributions(const figures::Model& model) {
  const std::size_t count = model.grid().size();
  if (!model.HasTimes() || count > kMaxStepDistributions) return nullptr;
  Json all = {{"percents", kPercents}};
  for (const Phase phase : figures::AllPhases()) {
    if (count > kMaxDistributions && phase != Phase::kStep && phase != Phase::kDetect) continue;
    const std::string name = figures::PhaseName(phase);
    Json quantiles = Json::array(), means = Json::array();
    for (const figures::GridPoint& point : model.grid()) {
      const figures::MeasuredPoint* measured = point.measured;
      quantiles.push_back(measured == nullptr
                              ? Json(nullptr)
                              : QuantilesOf(model.times().Of(*measured, phase).cycles));
      means.push_back(measured == nullptr ? Json(nullptr)
                                          : RepeatMeans(model.file(), *measured, phase));
    }
    all["quantiles"][name] = std::move(quantiles);
    all["repeat_means"][name] = std::move(means);
  }
  return all;
}

}  // namespace cdb::printers
