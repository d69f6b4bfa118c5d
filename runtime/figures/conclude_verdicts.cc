// Conclusions about the limits of sound simulation (conclusions.h).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/boundaries.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/detectors.h"
#include "runtime/figures/model.h"
#include "runtime/figures/ratios.h"
#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

class VerdictConclusion {
 public:
  explicit VerdictConclusion(const results::ResultFile& file) : file_(file) {
    for (const Point& at : AllPoints(file)) {
      const Ending ending = WorstEnding(file, at);
      if (ending.Rank() < 0) continue;
      verdicts_[at] = ending.Word();
      for (Cell& cell : CellsThatRan(file, at)) {
        const Ending of_run = EndingOf(file, cell);
        if (of_run.Rank() == ending.Rank()) worst_.push_back(cell);
        if (of_run.judgement.verdict == protocol::Verdict::kStable) sound_.push_back(cell);
        if (of_run.Word() == ending.Word() && !of_run.judgement.criterion.empty())
          criteria_[ending.Word()].insert(of_run.judgement.criterion);
      }
    }
  }

  std::optional<Conclusion> Get() const {
    const std::size_t all = verdicts_.size();
    std::map<std::string, std::size_t> counts;
    for (const auto& [at, word] : verdicts_) ++counts[word];
    const std::size_t stable = CountOf(counts, "stable"), unknown = CountOf(counts, "unknown");
    if (all == unknown) return std::nullopt;
    const char* question = "Is the simulation sound?";
    if (all == 1 && stable == 0)
      return Conclusion{question,
                        fmt::format("No: the verdict is {}{}{}.", counts.begin()->first,
                                    CriteriaText(counts.begin()->first), BadText()),
                        "stability", Certainty::kFault};
    const bool is_open = LeavesVitalOpen(file_, sound_);
    if (stable == all) {
      const std::string where =
          all == 1 ? std::string() : fmt::format(" in any of {} configurations", all);
      const std::string answer =
          is_open    ? fmt::format("Nothing wrong was found{}, as far as was checked.", where)
          : all == 1 ? "Yes: it is stable."
                     : fmt::format("Yes: all {} configurations are stable.", all);
      return Conclusion{question, answer + Remarks(), "stability",
                        is_open ? Certainty::kUnknown : Certainty::kClear};
    }
    std::vector<std::string> others;
    for (const auto& [word, count] : counts)
      if (word != "stable")
        others.push_back(fmt::format("{} {}{}", count, word, CriteriaText(word)));
    return Conclusion{"Where does the simulation stop being sound?",
                      fmt::format("{} of {} configurations are stable{} ({}).", stable, all,
                                  is_open ? ", as far as was checked" : "", JoinWords(others)) +
                          BoundaryText(file_, verdicts_, {.good = "stable"}) + Remarks(),
                      "stability", Certainty::kFault};
  }

 private:
  /// ` by friction_error, impact_error`; empty if the word says it.
  std::string CriteriaText(const std::string& word) const {
    const auto found = criteria_.find(word);
    if (found == criteria_.end() || found->second.contains(word)) return {};
    return fmt::format(" by {}", fmt::join(found->second, ", "));
  }

  /// How the motion depends on the detector; and ` Not checked: …`, of the runs that are called
  /// stable.
  std::string Remarks() const {
    std::string all;
    for (const std::string& text : {SameMotionText(file_), OpenQuestionsText(file_, sound_)})
      if (!text.empty()) all += " " + text;
    return all;
  }

  /// ` (3 of 2000 objects)`, if there is one point.
  std::string BadText() const {
    const std::string text = BadObjectsText(file_, worst_.at(0));
    return text.empty() ? text : fmt::format(" ({})", text);
  }

  static std::size_t CountOf(const std::map<std::string, std::size_t>& counts, const char* word) {
    const auto found = counts.find(word);
    return found == counts.end() ? 0 : found->second;
  }

  const results::ResultFile& file_;
  std::map<Point, std::string> verdicts_;
  std::map<std::string, std::set<std::string>> criteria_;  ///< by verdict
  /// The runs that end as the verdict of their point, and those that are stable.
  std::vector<Cell> worst_, sound_;
};

constexpr std::string_view kCertaintyNames[] = {"clear", "tie", "unknown", "fault"};

}  // namespace

void ConcludeVerdicts(const Model& model, std::vector<Conclusion>& all) {
  if (auto conclusion = VerdictConclusion(model.file()).Get())
    all.push_back(*std::move(conclusion));
}

std::string_view CertaintyName(Certainty certainty) {
  return kCertaintyNames[static_cast<std::size_t>(certainty)];
}

namespace {

/// The kinds of conclusions about times, other than `budget`, which regards noise itself.
constexpr std::string_view kOfTimes[] = {"fastest", "detect",      "broad", "scaling",
                                         "growth",  "worst_cycle", "error", "effects"};

/// Conclusions about times are not clear if the machine was noisy in half of the runs or more. The
/// repeats of all configurations take turns, so disturbances bias a ratio less than a time.
void DoubtNoisyTimes(const Model& model, std::vector<Conclusion>& all) {
  const std::vector<Cell>& cells = model.runs().good;
  const std::size_t noisy = CountNoisy(model.file(), cells);
  if (noisy == 0 || 2 * noisy < cells.size()) return;
  const std::string runs = cells.size() == 1 ? ""
                           : noisy == cells.size()
                               ? " in all runs"
                               : fmt::format(" in {} of {} runs", noisy, cells.size());
  for (Conclusion& of : all) {
    if (std::ranges::find(kOfTimes, of.kind) == std::end(kOfTimes)) continue;
    const bool is_ratio = of.kind != "error" && !model.file().axes().empty();
    if (is_ratio && of.certainty != Certainty::kClear) continue;
    if (of.certainty == Certainty::kClear) of.certainty = Certainty::kUnknown;
    of.answer += fmt::format(" The machine was noisy{}: {}.", runs,
                             is_ratio ? "the order is more certain than the factors"
                                      : "without disturbances, a step takes less");
  }
}

}  // namespace

std::vector<Conclusion> Conclusions(const Model& model) {
  std::vector<Conclusion> all;
  ConcludeBudget(model, all);
  ConcludeErrors(model, all);
  ConcludeStep(model, all);
  ConcludeDetectors(model, all);
  ConcludeVerdicts(model, all);
  ConcludeAxes(model, all);
  ConcludeEffects(model, all);
  ConcludeDetectorLimits(model, all);
  DoubtNoisyTimes(model, all);
  return all;
}

// Conclusions about the time of a step along the axes (conclusions.h).

namespace {

using protocol::Phase;

std::string CellsNote(std::size_t cells, std::size_t of) {
  if (of < 2) return {};
  return cells < of ? fmt::format(", the geometric mean over {} of {} cells", cells, of)
                    : fmt::format(", the geometric mean over {} cells", cells);
}

/// The times of a step with a value of the axis over those with the first, where both are sound.
std::vector<Estimate> RatiosToFirst(const Comparison& comparison, std::size_t value) {
  std::vector<Estimate> ratios;
  for (const ComparedPoint& point : comparison.points) {
    const MeasuredPoint *from = point.values[0], *to = point.values[value];
    if (from == nullptr || to == nullptr || !from->IsSound() || !to->IsSound()) continue;
    if (auto ratio = comparison.RatioAt(point, value, Phase::kStep))
      ratios.push_back(*std::move(ratio));
  }
  return ratios;
}

/// Compares the first and the last value of an axis of numbers.
void AddScaling(const Model& model, std::size_t axis, std::vector<Conclusion>& all) {
  const plan::Axis& along = model.axis(axis);
  const Comparison comparison = CompareValues(model, axis, 0);
  if (comparison.is_void) return;
  const std::size_t last = along.values.size() - 1;
  const std::vector<Estimate> ratios = RatiosToFirst(comparison, last);
  if (ratios.empty()) return;
  const Estimate ratio = GeometricMeanOf(ratios);
  const Certainty certainty =
      CertaintyOf(model.times().IntervalOf(ratio), model.times().bootstrap().kind());
  const auto at = [&](std::size_t value) {
    return fmt::format("{} {}{}", along.name, terminal::CoordinateText(along, value),
                       along.unit.empty() ? "" : " " + along.unit);
  };
  std::string answer = fmt::format("A step takes {} times as long with {} as with {}{}{}.",
                                   terminal::ShortNumber(ratio.value), at(last), at(0),
                                   IntervalNote(model.times(), ratio),
                                   CellsNote(ratios.size(), comparison.points.size()));
  if (certainty == Certainty::kTie)
    answer += " The interval includes 1: this may be no difference.";
  // The ends say nothing about a value between them.
  constexpr double kBeyond = 1.25;
  std::string between;
  double farthest = kBeyond;
  for (std::size_t value = 1; value < last; ++value) {
    const std::vector<Estimate> here = RatiosToFirst(comparison, value);
    if (here.size() != ratios.size()) continue;
    const double middle = GeometricMeanOf(here).value;
    const double beyond =
        std::fmax(middle / std::fmax(1, ratio.value), std::fmin(1, ratio.value) / middle);
    if (!(beyond > farthest)) continue;
    farthest = beyond;
    between = fmt::format(" Between them lies an extreme: {} times with {}.",
                          terminal::ShortNumber(middle), at(value));
  }
  answer += between;
  if (model.times().bootstrap().size() == 1) answer += OneRepeatNote();
  const Interval interval = model.times().IntervalOf(ratio);
  all.push_back(
      {fmt::format("How does the time of a step change with {}?", AxisWords(along)),
       std::move(answer), "scaling", certainty,
       Effect{AxisWords(along), at(0), at(last), ratio.value,
              std::isnan(interval.low) ? std::nullopt
                                       : std::optional(std::pair(interval.low, interval.high))}});
}

/// Finds the fastest value of an axis of words.
void AddFastestValue(const Model& model, std::size_t axis, std::vector<Conclusion>& all) {
  const plan::Axis& along = model.axis(axis);
  const Comparison comparison = CompareValues(model, axis, std::nullopt);
  if (comparison.is_void) return;
  const auto ranking = RankValues(
      comparison,
      [&](const MeasuredPoint& point) { return model.times().Of(point, Phase::kStep).mean; }, {});
  if (!ranking) return;
  const Ranking::Other &next = ranking->others[0], &last = ranking->others.back();
  const auto against = [&](const Ranking::Other& other) {
    return fmt::format("{} takes {} times as long{}", terminal::CoordinateText(along, other.value),
                       terminal::ShortNumber(other.ratio.value),
                       IntervalNote(model.times(), other.ratio));
  };
  std::string answer =
      fmt::format("{}: {}", terminal::CoordinateText(along, ranking->best), against(next));
  if (ranking->others.size() > 1) answer += fmt::format(", and {}", against(last));
  answer += CellsNote(ranking->cells, ranking->of) + ".";
  if (next.certainty == Certainty::kTie) answer += " The first two cannot be told apart.";
  if (model.times().bootstrap().size() == 1) answer += OneRepeatNote();
  all.push_back({fmt::format("Which {} has the shortest step?", AxisWords(along)),
                 std::move(answer), "scaling", ranking->certainty()});
}

/// The growth over all runs, if no detectors are compared.
void AddGrowthOfAll(const Model& model, std::vector<Conclusion>& all) {
  const auto growth = GrowthByRow(model, {});
  if (!growth || !growth->is_matched || growth->exponents.empty()) return;
  const DetectorGrowth::Exponent& exponent = growth->exponents.begin()->second;
  if (std::isnan(exponent.fit.p)) return;
  all.push_back(
      {"How does collision detection grow with the number of objects?",
       fmt::format("As n^{:.2f} (95 % interval of the fit {:.2f} .. {:.2f}) from {:.0f} "
                   "to {:.0f} objects{}.",
                   exponent.fit.p, exponent.fit.interval.low, exponent.fit.interval.high,
                   exponent.least, exponent.most, growth->is_mean ? ", over all other axes" : ""),
       "growth", Certainty::kUnknown});
}

}  // namespace

void ConcludeAxes(const Model& model, std::vector<Conclusion>& all) {
  if (!model.HasTimes() || model.points().empty()) return;
  const auto detectors = model.detector_axis();
  for (std::size_t i = 0; i < model.file().axes().size(); ++i) {
    const plan::Axis& axis = model.axis(i);
    // Times over seeds only scatter.
    if (i == detectors || axis.values.size() < 2 || axis.name == "seed") continue;
    if (!axis.sampled.empty()) continue;
    if (axis.IsText()) {
      AddFastestValue(model, i, all);
    } else {
      AddScaling(model, i, all);
    }
  }
  if (!detectors || model.axis(*detectors).values.size() < 2) AddGrowthOfAll(model, all);
}

void ConcludeStep(const Model& model, std::vector<Conclusion>& all) {
  if (!model.file().axes().empty() || !model.HasTimes() || model.points().empty()) return;
  const MeasuredPoint& point = model.points()[0];
  if (!point.IsSound()) return;
  const Estimate& step = model.times().Of(point, Phase::kStep).mean;
  Phase largest = Phase::kBroad;
  const auto time_of = [&](Phase phase) { return model.times().Of(point, phase).mean.value; };
  for (const Phase phase : {Phase::kNarrow, Phase::kSolve, Phase::kIntegrate})
    if (time_of(phase) > time_of(largest) || std::isnan(time_of(largest))) largest = phase;
  const terminal::TimeUnit unit = terminal::TimeUnit::For(step.value);
  all.push_back({"What does a step take?",
                 fmt::format("{}{}. Its largest phase is {}: {}, {:.0f} % of the step.",
                             TimeText(step.value), IntervalNote(model.times(), step, 1 / unit.ns),
                             protocol::PhaseNames()[protocol::IndexOf(largest)],
                             TimeText(time_of(largest)), 100 * time_of(largest) / step.value),
                 "fastest",
                 model.times().bootstrap().kind() == IntervalKind::kInterval
                     ? Certainty::kClear
                     : Certainty::kUnknown});
}

}  // namespace cdb::figures
