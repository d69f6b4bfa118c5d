// Conclusions about detectors (conclusions.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "compiler/schema/catalogue.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/detectors.h"
#include "runtime/figures/ratios.h"
#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// Limit of exceptions that are named individually.
constexpr std::size_t kMaxExceptions = 3;
/// Limit of points whose worst cycles get intervals, which takes a second bootstrap.
constexpr std::size_t kMaxWorstPoints = 1000;
/// A smaller relative difference in the memory of a process is not worth a word.
constexpr double kLikeMemory = 0.02;

class DetectorConclusions {
 public:
  DetectorConclusions(const Model& model, std::size_t axis)
      : model_(model),
        file_(model.file()),
        axis_(axis),
        comparison_(CompareValues(model, axis, std::nullopt)) {
    for (std::size_t i = 0; i < Axis().values.size(); ++i)
      if (!IsHonest(i)) left_out_.insert(i);
  }

  std::vector<Conclusion> Times() {
    AddPairs();
    if (!model_.HasTimes() || comparison_.is_void) return std::move(all_);
    if (comparison_.MatchedCount() == 0)
      Add({"Which detector is the fastest?",
           "Unknown: no cell has a sound run of every detector with the same omissions.", "fastest",
           Certainty::kUnknown});
    const bool has_world = HasWorld();
    AddTimes(protocol::Phase::kStep, "Which detector takes the least time for a step?", "fastest",
             (has_world ? BroadShare() : "") + NotRanked() + NotChecked());
    if (has_world)  // otherwise the step is nothing else
      AddTimes(protocol::Phase::kDetect,
               "Which detector takes the least time for collision detection alone?", "detect",
               UnlikePairs());
    AddGrowth(protocol::Phase::kDetect,
              "Which detector grows the least with the number of objects?", "collision detection");
    if (has_world && HaveOneNarrowPhase()) {
      AddTimes(protocol::Phase::kBroad,
               "Which detector takes the least time for the broad phase alone?", "broad",
               Sorting());
      AddGrowth(protocol::Phase::kBroad,
                "Which broad phase grows the least with the number of objects?", "the broad phase");
    }
    return std::move(all_);
  }

  std::vector<Conclusion> Limits() {
    if (!model_.HasTimes() || comparison_.is_void) return {};
    AddWorstCycle();
    AddMemory();
    return std::move(all_);
  }

 private:
  const plan::Axis& Axis() const { return file_.axes()[axis_]; }
  std::string Name(std::size_t value) const { return terminal::CoordinateText(Axis(), value); }
  /// Where the ranked detectors list the most different numbers of pairs, if these differ by a
  /// twentieth or more; with a remedy.
  std::string UnlikePairs() const {
    if (!file_.Has("pairs")) return {};
    constexpr double kLikePairs = 1.05;
    double largest = kLikePairs;
    std::string text;
    for (const ComparedPoint& point : comparison_.points) {
      std::vector<std::pair<double, std::size_t>> counts;
      for (std::size_t i = 0; i < point.values.size(); ++i)
        if (point.values[i] != nullptr && point.values[i]->IsSound() && !left_out_.contains(i))
          if (const double count = model_.CountOf(*point.values[i], "pairs"); count >= 0)
            counts.emplace_back(count, i);
      if (counts.size() < 2) continue;
      const auto [least, most] = std::ranges::minmax(counts);
      const double ratio = most.first / std::fmax(least.first, 1);
      if (ratio <= largest) continue;
      largest = ratio;
      const std::string place = PlaceText(file_, OtherAxes(file_, axis_), point.at);
      text = fmt::format(" They list different pairs: {} {} and {} {}{}.", Name(most.second),
                         terminal::ShortNumber(most.first), Name(least.second),
                         terminal::ShortNumber(least.first),
                         place.empty() ? place : fmt::format(" at {}", place));
      const std::vector<std::string>& kept = point.values[most.second]->kept;
      if (IsOfBullet(Name(most.second)) && !IsOfBullet(Name(least.second)) &&
          std::ranges::find(kept, "wall_pairs") != kept.end() && SortsPairs(file_))
        text +=
            " Bullet's own pair every object with every wall; `omit auto, wall_pairs` leaves "
            "the pairs out that no box reaches.";
    }
    return text;
  }
  void Add(Conclusion conclusion) { all_.push_back(std::move(conclusion)); }

  /// True if the detector does the work that is timed: it finds pairs, and misses none.
  bool IsHonest(std::size_t value) const {
    const schema::DetectorInfo* info = schema::FindDetector(Name(value));
    if (info != nullptr && info->family == "none") return false;
    return std::ranges::none_of(model_.findings(), [&](const DetectorFindings& of) {
      return of.detector == Name(value) && of.missed > 0;
    });
  }

  /// True if the ranked detectors are broad phases, whose pairs Bullet's narrow phase handles.
  bool HaveOneNarrowPhase() const {
    for (std::size_t i = 0; i < Axis().values.size(); ++i) {
      const schema::DetectorInfo* info = schema::FindDetector(Name(i));
      if (!left_out_.contains(i) && (info == nullptr || info->HasPhase("narrow"))) return false;
    }
    return true;
  }

  void AddTimes(protocol::Phase phase, const char* question, const char* kind,
                const std::string& caveat) {
    const auto figure = [&](const MeasuredPoint& point) {
      return model_.times().Of(point, phase).mean;
    };
    AddRanking(question, kind, figure, "time", caveat);
  }

  /// False if every run was on a trace, in which a step is only detection.
  bool HasWorld() const {
    return std::ranges::any_of(model_.TimedPhases(), [](protocol::Phase phase) {
      return phase == protocol::Phase::kSolve || phase == protocol::Phase::kIntegrate;
    });
  }

  void AddWorstCycle() {
    if (model_.points().size() > kMaxWorstPoints) return;
    CycleTimes longest(file_, CycleStatistic::kMax);
    AddRanking(
        "Which detector has the shortest worst cycle?", "worst_cycle",
        [&](const MeasuredPoint& point) {
          return longest.FigureOf(point, protocol::Phase::kDetect);
        },
        "time");
  }

  void AddMemory() {
    if (!file_.Has("peak_rss")) return;
    const Bootstrap& bootstrap = model_.times().bootstrap();
    const auto figure = [&](const MeasuredPoint& point) -> Estimate {
      std::vector<double> bytes;
      for (const auto& cell : point.cells) bytes.push_back(file_.ReadReal("peak_rss", cell));
      if (bytes.size() == bootstrap.size()) return bootstrap.MeanEstimate(bytes);
      return {Mean(bytes), std::vector(bootstrap.draws().size(), kNone), bytes.size()};
    };
    const auto ranking = RankValues(comparison_, figure, left_out_);
    if (ranking && ranking->others.back().ratio.value < 1 + kLikeMemory) return;
    AddRanking("Which detector takes the least memory?", "memory", figure, "memory");
  }

  void AddRanking(const char* question, const char* kind, const FigureOfPoint& figure,
                  const char* quantity, const std::string& caveat = "") {
    const auto ranking = RankValues(comparison_, figure, left_out_);
    if (!ranking) return;
    Add({question, Winner(*ranking, quantity) + Where(*ranking) + caveat, kind,
         ranking->certainty()});
  }

  /// Compares the best with those that it is tied with, or else with the next, and with the last.
  std::string Winner(const Ranking& ranking, const char* quantity) const {
    std::vector<std::string> ties = {Name(ranking.best)};
    std::size_t shown = 0;  // of the others
    for (std::size_t i = 0; i < ranking.others.size(); ++i) {
      if (ranking.others[i].certainty != Certainty::kTie) continue;
      ties.push_back(Name(ranking.others[i].value));
      shown = i;
    }
    const auto times = [&](std::size_t other) {
      const Estimate& ratio = ranking.others[other].ratio;
      return fmt::format("{} times the {} of {}{}.", terminal::ShortNumber(ratio.value), quantity,
                         ties[0], IntervalNote(model_.times(), ratio));
    };
    const auto name = [&](std::size_t other) { return Name(ranking.others[other].value); };
    std::string text = ties.size() > 1 ? fmt::format("{} cannot be told apart: {} takes {}",
                                                     JoinWords(ties), name(shown), times(shown))
                                       : fmt::format("{}. Next is {}, with {}", ties[0],
                                                     name(shown), times(shown));
    const std::size_t last = ranking.others.size() - 1;
    return last > shown ? fmt::format("{} Last is {}, with {}", text, name(last), times(last))
                        : text;
  }

  /// The cells compared, and the exceptions where another value is better.
  std::string Where(const Ranking& ranking) const {
    std::string text;
    if (ranking.of > 1)
      text += fmt::format(" These are geometric means over {} cells{}.",
                          ranking.cells < ranking.of
                              ? fmt::format("{} of {}", ranking.cells, ranking.of)
                              : fmt::format("{}", ranking.cells),
                          ranking.cells < ranking.of ? " (those that all detectors have)" : "");
    if (model_.times().bootstrap().size() == 1) text += OneRepeatNote();
    const std::size_t count = ranking.exceptions.size();
    if (count == 0) return text;
    std::vector<std::string> places;
    const std::vector<std::size_t> others = OtherAxes(file_, axis_);
    for (std::size_t i = 0; i < std::min(count, kMaxExceptions); ++i)
      places.push_back(fmt::format("{} at {}", Name(ranking.exceptions[i].value),
                                   PlaceText(file_, others, ranking.exceptions[i].at)));
    if (count > kMaxExceptions)
      return text +
             fmt::format(" It is not the best everywhere: another is the best in {} of {} cells.",
                         count, ranking.cells);
    return text + fmt::format(" It is not the best everywhere: {}.", JoinWords(places));
  }

  /// How much of a step a detector can change at all: ` The broad phase is 2 to 9 % of a step.`
  std::string BroadShare() const {
    double least = kNone, most = kNone;
    for (const MeasuredPoint& point : model_.points()) {
      if (!point.IsSound() || left_out_.contains(point.at[axis_])) continue;
      const auto time_of = [&](protocol::Phase phase) {
        return model_.times().Of(point, phase).mean.value;
      };
      const double share = 100 * time_of(protocol::Phase::kBroad) / time_of(protocol::Phase::kStep);
      least = std::fmin(least, share);
      most = std::fmax(most, share);
    }
    if (std::isnan(least)) return {};
    const auto text = [](double percent) {
      return fmt::format(fmt::runtime(percent < 1 ? "{:.1g}" : "{:.0f}"), percent);
    };
    const std::string low = text(least), high = text(most);
    return fmt::format(" The broad phase is {}{} % of a step.", low == high ? "" : low + " to ",
                       high);
  }

  std::string Sorting() const {
    const std::string text = SortingText(file_);
    return text.empty() ? text : " " + text;
  }

  /// Names the detectors that were not ranked because they did not do the work.
  std::string NotRanked() const {
    std::string text;
    for (const std::size_t value : left_out_)
      for (const DetectorFindings& of : model_.findings())
        if (of.detector == Name(value) && of.missed > 0)
          text += fmt::format(" {} is not ranked: it missed {} of {} pairs.", of.detector,
                              of.missed, of.exact);
    return text;
  }

  /// Names the plug-ins whose pairs were not compared with exact ones.
  std::string NotChecked() const {
    std::vector<std::string> names;
    for (const DetectorFindings& of : model_.findings())
      if (of.runs == 0 && of.unwatched_runs > 0 && schema::FindDetector(of.detector) == nullptr)
        names.push_back(of.detector);
    if (names.empty()) return {};
    return fmt::format(
        " The pairs of {} were not compared with exact ones: `record pairs` says whether {} any.",
        names.size() == 1 ? names[0] + ", a plug-in," : JoinWords(names) + ", plug-ins,",
        names.size() == 1 ? "it misses" : "they miss");
  }

  void AddPairs() {
    std::uint64_t exact = 0, missed = 0;
    std::vector<std::string> wrong;
    for (const DetectorFindings& of : model_.findings()) {
      exact += of.exact;
      missed += of.missed;
      if (of.missed > 0)
        wrong.push_back(fmt::format("{} missed {} of {} pairs, in {} of {} runs", of.detector,
                                    of.missed, of.exact, of.wrong_runs, of.runs));
    }
    if (exact == 0) return;
    const std::string question = "Did every detector find every pair?";
    if (missed == 0) {
      Add({question, fmt::format("Yes: none of {} pairs was missed.", exact), "pairs",
           Certainty::kClear});
    } else {
      Add({question, fmt::format("No: {}.", JoinWords(wrong)), "pairs", Certainty::kFault});
    }
  }

  void AddGrowth(protocol::Phase phase, const char* question, const char* of_what) {
    const auto growth = GrowthByRow(model_, {axis_}, phase);
    if (!growth || !growth->is_matched) return;
    using Grown = std::pair<const DetectorGrowth::Exponent*, std::size_t>;
    std::vector<Grown> all;
    for (const auto& [row, exponent] : growth->exponents)
      if (!std::isnan(exponent.fit.p) && !left_out_.contains(row[0]))
        all.emplace_back(&exponent, row[0]);
    if (all.size() < 2) return;
    std::ranges::sort(all, {}, [](const Grown& of) { return of.first->fit.p; });
    const auto& [least, name] = all[0];
    std::vector<std::string> rest, ties;
    for (std::size_t i = 1; i < all.size(); ++i) {
      rest.push_back(fmt::format("{} n^{:.2f}", Name(all[i].second), all[i].first->fit.p));
      if (!GrowsMore(*all[i].first, *least)) ties.push_back(Name(all[i].second));
    }
    const Interval& interval = least->fit.interval;
    Add({question,
         fmt::format("{}: its time for {} grows as n^{:.2f} (95 % interval of the fit {:.2f} .. "
                     "{:.2f}) from {:.0f} to {:.0f} objects; {}.{}",
                     Name(name), of_what, least->fit.p, interval.low, interval.high, least->least,
                     least->most, JoinWords(rest),
                     ties.empty() ? ""
                                  : fmt::format(" The growth of {} cannot be told from it.",
                                                JoinWords(ties))),
         "growth",
         !ties.empty()                                                  ? Certainty::kTie
         : model_.times().bootstrap().kind() == IntervalKind::kInterval ? Certainty::kClear
                                                                        : Certainty::kUnknown});
  }

  /// Whether the ratio of the times surely grows with the number of objects: what bends both curves
  /// does not count.
  static bool GrowsMore(const DetectorGrowth::Exponent& more,
                        const DetectorGrowth::Exponent& less) {
    if (more.curves.size() != less.curves.size()) return false;
    std::vector<PowerGroup> ratios = more.curves;
    for (std::size_t i = 0; i < ratios.size(); ++i) {
      if (ratios[i].size() != less.curves[i].size()) return false;
      for (std::size_t j = 0; j < ratios[i].size(); ++j)
        ratios[i][j].second /= less.curves[i][j].second;
    }
    return FitPower(ratios).interval.low > 0;
  }

  const Model& model_;
  const results::ResultFile& file_;
  const std::size_t axis_;
  const Comparison comparison_;
  std::set<std::size_t> left_out_;  ///< detectors that must not win
  std::vector<Conclusion> all_;
};

/// The axis of detectors, if there are several.
std::optional<std::size_t> ComparedDetectors(const Model& model) {
  const auto axis = model.detector_axis();
  if (!axis || model.axis(*axis).values.size() < 2 || model.points().empty()) return std::nullopt;
  return axis;
}

}  // namespace

void ConcludeDetectors(const Model& model, std::vector<Conclusion>& all) {
  const auto axis = ComparedDetectors(model);
  if (!axis) return;
  for (Conclusion& conclusion : DetectorConclusions(model, *axis).Times())
    all.push_back(std::move(conclusion));
}

void ConcludeDetectorLimits(const Model& model, std::vector<Conclusion>& all) {
  const auto axis = ComparedDetectors(model);
  if (!axis) return;
  for (Conclusion& conclusion : DetectorConclusions(model, *axis).Limits())
    all.push_back(std::move(conclusion));
}

}  // namespace cdb::figures
