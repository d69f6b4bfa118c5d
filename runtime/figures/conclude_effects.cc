// Conclusions about the effects of sampled parameters (conclusions.h).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/schema/metrics.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/effects/effects.h"
#include "runtime/figures/ratios.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// Limit of values of the axis of detectors that get separate conclusions.
constexpr std::size_t kMaxDetectors = 4;
/// Limits of the parameters and of the pairs of them that are named; pairs with a smaller share of
/// the variance are not.
constexpr std::size_t kMaxMains = 6, kMaxPairs = 3;
constexpr double kLeastShare = 0.01;

class EffectConclusions {
 public:
  EffectConclusions(const Model& model, std::size_t axis, std::vector<Conclusion>& all)
      : model_(model), axis_(axis), sampled_(model.axis(axis).sampled), all_(all) {}

  /// `what`: `the time of a step`.
  void Add(const std::string& what, std::string_view kind,
           const std::function<double(const MeasuredPoint&)>& figure_of) {
    const auto detectors = model_.detector_axis();
    const std::size_t count = detectors ? model_.axis(*detectors).values.size() : 1;
    if (count == 1 || count > kMaxDetectors) return AddFor({}, what, kind, figure_of);
    for (std::size_t i = 0; i < count; ++i) AddFor(i, what, kind, figure_of);
  }

 private:
  static std::string Share(double share) {
    const double percent = 100 * share;
    if (percent < 0.1) return "less than 0.1 %";
    return percent < 9.95 ? fmt::format("{:.2g} %", percent) : fmt::format("{:.0f} %", percent);
  }
  /// The geometric mean at each point over all other axes but detectors, where all are measured and
  /// sound; NaN elsewhere.
  std::vector<double> FiguresOf(std::optional<std::size_t> detector,
                                const std::function<double(const MeasuredPoint&)>& figure_of) {
    std::vector<std::vector<double>> values(model_.axis(axis_).values.size());
    for (const GridPoint& point : model_.grid()) {
      if (detector && point.at[*model_.detector_axis()] != *detector) continue;
      values[point.at[axis_]].push_back(point.IsVoid() ? kNone : figure_of(*point.measured));
    }
    std::size_t most = 0;
    for (const auto& of : values) most = std::max(most, of.size());
    std::vector<double> figures;
    for (const auto& of : values)
      figures.push_back(of.size() == most && most > 0 ? GeometricMean(of) : kNone);
    return figures;
  }

  void AddFor(std::optional<std::size_t> detector, const std::string& what, std::string_view kind,
              const std::function<double(const MeasuredPoint&)>& figure_of) {
    const std::vector<double> figures = FiguresOf(detector, figure_of);
    if (std::ranges::none_of(figures, [](double figure) { return figure > 0; })) return;
    const auto fit = effects::FitEffects(sampled_, figures);
    const std::string of = detector ? " of " + terminal::CoordinateText(
                                                   model_.axis(*model_.detector_axis()), *detector)
                                    : std::string();
    const std::string question =
        fmt::format("What changes {}{} over {}?", what, of, AxisWords(model_.axis(axis_)));
    if (!fit) {
      all_.push_back(
          {question,
           fmt::format("Unknown: of {} points, too few are sound and have a figure above 0 "
                       "({} would do), or the figure is the same at all of them.",
                       figures.size(), 2 * (sampled_.size() + 1)),
           kind, Certainty::kUnknown});
      return;
    }
    std::vector<std::string> parts;
    const auto interval_of = [&](const effects::MainEffect& main) {
      const double margin = StudentQuantile(fit->freedom) * main.error;
      return Interval{std::exp(main.log_ratio - margin), std::exp(main.log_ratio + margin)};
    };
    for (const effects::MainEffect& main : fit->mains) {
      if (parts.size() == kMaxMains) break;
      const plan::Coordinates& parameter = sampled_[main.parameter];
      parts.push_back(fmt::format(
          "{} from {} to {}: {} times (95 % interval {}), {} of the variance", parameter.name,
          terminal::ShortNumber(parameter.first), terminal::ShortNumber(parameter.last),
          terminal::ShortNumber(std::exp(main.log_ratio)), IntervalText(interval_of(main)),
          Share(main.share)));
    }
    std::string answer = fmt::format("{}", fmt::join(parts, "; "));
    if (fit->mains.size() > parts.size())
      answer += fmt::format("; {} others have less", fit->mains.size() - parts.size());
    answer += ".";
    std::vector<std::string> pairs;
    for (const effects::Interaction& pair : fit->interactions)
      if (pair.share >= kLeastShare && pairs.size() < kMaxPairs)
        pairs.push_back(fmt::format("{} with {} {}", sampled_[pair.a].name, sampled_[pair.b].name,
                                    Share(pair.share)));
    if (!pairs.empty())
      answer += fmt::format(" Together, beyond that: {}.", JoinWords(pairs));
    else if (!fit->has_interactions)
      answer += " What they do together takes more points to tell.";
    answer += fmt::format(" Not explained: {}; by a fit to {} points", Share(fit->unexplained),
                          fit->points);
    if (fit->points < figures.size())
      answer += fmt::format("; {} are left out, as some run is not sound or has no such figure",
                            figures.size() - fit->points);
    const Interval largest = interval_of(fit->mains[0]);
    all_.push_back({question, answer + ".", kind,
                    largest.low > 1 || largest.high < 1 ? Certainty::kClear : Certainty::kTie});
  }

  const Model& model_;
  const std::size_t axis_;
  const std::vector<plan::Coordinates>& sampled_;
  std::vector<Conclusion>& all_;
};

}  // namespace

void ConcludeEffects(const Model& model, std::vector<Conclusion>& all) {
  for (std::size_t i = 0; i < model.file().axes().size(); ++i) {
    if (model.axis(i).sampled.empty()) continue;
    EffectConclusions effects(model, i, all);
    if (model.HasTimes())
      effects.Add("the time of a step", "effects", [&](const MeasuredPoint& point) {
        return model.TimeOf(point, protocol::Phase::kStep).value;
      });
    for (const schema::ErrorInfo& error : schema::Errors()) {
      const std::string name(error.name);
      if (!model.file().Has("accuracy/" + name)) continue;
      effects.Add("the error of " + name, "error_effects",
                  [&](const MeasuredPoint& point) { return model.ErrorOf(point, name); });
    }
  }
}

}  // namespace cdb::figures
