#include "runtime/document/cycles.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "runtime/statistics/cells.h"
#include "runtime/statistics/numbers.h"

namespace cdb::document {
namespace {

using measure::Phase;

constexpr std::size_t kMaxBins = 200, kMaxTimelines = 60;
constexpr std::size_t kMaxDistributions = 500, kMaxStepDistributions = 2000;
constexpr int kPercents[] = {0, 5, 10, 20, 25, 30, 40, 50, 60, 70, 75, 80, 90, 95, 100};
constexpr int kDigits = 4;  // more than a screen can show

/// The points whose cycles are drawn: the same number for each detector.
std::vector<std::size_t> ChooseTimelines(const DocumentSource& source) {
  const auto axis = statistics::DetectorAxis(source.file());
  const std::size_t detectors = axis ? source.file().axes()[*axis].values.size() : 1;
  const std::size_t each = source.points().size() <= kMaxTimelines
                               ? source.points().size()
                               : std::max<std::size_t>(1, kMaxTimelines / detectors);
  std::map<std::size_t, std::size_t> taken;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < source.points().size() && chosen.size() < kMaxTimelines; ++i) {
    const DocumentSource::GridPoint& point = source.points()[i];
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
    return JsonNumber(statistics::Percentile(cycles, kPercents[i] / 100.0), kDigits);
  });
}

/// The mean over the cycles, for each repeat of a point.
Json RepeatMeans(const store::ResultFile& file, const statistics::MeasuredPoint& point,
                 Phase phase) {
  Json means = Json::array();
  for (const store::ResultFile::Cell& cell : point.cells)
    means.push_back(JsonNumber(statistics::Mean(file.ReadDuration(phase, cell)), kDigits));
  return means;
}

}  // namespace

Json DocumentCycles(const DocumentSource& source) {
  if (!source.HasTimes() || source.IsLarge()) return nullptr;
  const std::vector<std::size_t> chosen = ChooseTimelines(source);
  // Cycles that ran; the file has room for more.
  std::size_t cycles = 0;
  for (const std::size_t i : chosen)
    cycles = std::max(cycles,
                      source.times().Of(*source.points()[i].measured, Phase::kStep).cycles.size());
  const auto bins = BinsOf(cycles);
  Json all = {{"points", chosen}, {"of", source.measured().size()}, {"bins", bins}};
  for (std::size_t phase = 0; phase < measure::kPhaseCount; ++phase)
    all[std::string(measure::PhaseNames()[phase])] = JsonColumn(chosen.size(), [&](std::size_t i) {
      const statistics::MeasuredPoint& point = *source.points()[chosen[i]].measured;
      return Binned(source.times().Of(point, static_cast<Phase>(phase)).cycles, bins);
    });
  return all;
}

Json DocumentDistributions(const DocumentSource& source) {
  const std::size_t count = source.points().size();
  if (!source.HasTimes() || count > kMaxStepDistributions) return nullptr;
  Json all = {{"percents", kPercents}};
  for (std::size_t i = 0; i < measure::kPhaseCount; ++i) {
    const auto phase = static_cast<Phase>(i);
    if (count > kMaxDistributions && phase != Phase::kStep && phase != Phase::kDetect) continue;
    const std::string name(measure::PhaseNames()[i]);
    Json quantiles = Json::array(), means = Json::array();
    for (const DocumentSource::GridPoint& point : source.points()) {
      const statistics::MeasuredPoint* measured = point.measured;
      quantiles.push_back(measured == nullptr
                              ? Json(nullptr)
                              : QuantilesOf(source.times().Of(*measured, phase).cycles));
      means.push_back(measured == nullptr ? Json(nullptr)
                                          : RepeatMeans(source.file(), *measured, phase));
    }
    all["quantiles"][name] = std::move(quantiles);
    all["repeat_means"][name] = std::move(means);
  }
  return all;
}

}  // namespace cdb::document
