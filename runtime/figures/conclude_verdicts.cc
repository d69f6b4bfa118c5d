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
#include "runtime/figures/conclusions.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/detectors.h"
#include "runtime/figures/model.h"
#include "runtime/figures/ratios.h"
#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

/// Limit of different lines of verdicts.
constexpr std::size_t kMaxLines = 2;

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
    if (all == 1)
      return Conclusion{question,
                        stable == 1
                            ? "Yes: it is stable." + OpenText()
                            : fmt::format("No: it is {}{}.", counts.begin()->first, BadText()),
                        "stability", stable == 1 ? Certainty::kClear : Certainty::kFault};
    if (stable == all)
      return Conclusion{question,
                        fmt::format("Yes: all {} configurations are stable.", all) + OpenText(),
                        "stability", Certainty::kClear};
    std::vector<std::string> others;
    for (const auto& [word, count] : counts)
      if (word != "stable") others.push_back(fmt::format("{} {}", count, word));
    return Conclusion{
        "Where does the simulation stop being sound?",
        fmt::format("{} of {} configurations are stable ({}).", stable, all, JoinWords(others)) +
            Along() + OpenText(),
        "stability", Certainty::kFault};
  }

 private:
  /// ` Not checked: …`, of the runs that are called stable.
  std::string OpenText() const {
    const std::string text = OpenQuestionsText(file_, sound_);
    return text.empty() ? text : " " + text;
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

  /// The number of adjacent points along the axis whose verdicts differ.
  std::size_t ChangesAlong(std::size_t axis) const {
    std::size_t changes = 0;
    for (const auto& [at, word] : verdicts_) {
      Point next = at;
      ++next[axis];
      const auto found = verdicts_.find(next);
      changes += found != verdicts_.end() && found->second != word ? 1 : 0;
    }
    return changes;
  }

  /// The axis of numbers along which verdicts change most.
  std::optional<std::size_t> OwnAxis() const {
    std::optional<std::size_t> own;
    std::size_t most = 0;
    for (std::size_t i = 0; i < file_.axes().size(); ++i) {
      if (file_.axes()[i].IsText()) continue;
      const std::size_t changes = ChangesAlong(i);
      if (changes <= most) continue;
      most = changes;
      own = i;
    }
    return own;
  }

  /// The verdicts along that axis, one sentence for all places with equal verdicts.
  std::string Along() const {
    const auto own = OwnAxis();
    if (!own) return {};
    std::map<Point, Line> lines;
    for (const auto& [at, word] : verdicts_) {
      Line& line = lines[Without(at, *own)];
      if (line.empty() || line.back().word != word) line.push_back({word, at[*own], at[*own]});
      line.back().last = at[*own];
    }
    std::map<std::string, std::vector<Point>> places;
    for (const auto& [place, line] : lines) places[TextOf(*own, line)].push_back(place);
    if (places.size() > kMaxLines) return BoundaryText(*own, lines);
    std::string text;
    for (const auto& [line, alike] : places)
      text += fmt::format(" Along {}{}: {}.", AxisWords(file_.axes()[*own]),
                          PlacesText(OtherAxes(file_, *own), alike), line);
    return text;
  }

  /// Adjacent points with the same verdict.
  struct Segment {
    std::string word;
    std::size_t first, last;
  };
  using Line = std::vector<Segment>;

  /// The stable part of the lines along an axis: from its lower or its upper end.
  struct Boundaries {
    bool is_low = true;
    /// By place: the last stable point, seen from that end; nullopt if none is.
    std::map<Point, std::optional<std::size_t>> last;
  };

  /// Nullopt if a line is stable again beyond an unsound point.
  static std::optional<Boundaries> BoundariesOf(const std::map<Point, Line>& lines, bool is_low) {
    Boundaries boundaries{.is_low = is_low, .last = {}};
    for (const auto& [place, line] : lines) {
      const auto stable = std::ranges::count(line, "stable", &Segment::word);
      const Segment& end = is_low ? line.front() : line.back();
      if (stable > 1 || (stable == 1 && end.word != "stable")) return std::nullopt;
      boundaries.last[place] =
          stable == 0 ? std::nullopt : std::optional(is_low ? end.last : end.first);
    }
    return boundaries;
  }

  /// `up to 200`, `from 30 on`, `nowhere`.
  std::string ReachText(std::size_t own, const Boundaries& boundaries,
                        std::optional<std::size_t> last) const {
    const plan::Axis& axis = file_.axes()[own];
    if (!last) return "nowhere";
    if (*last == (boundaries.is_low ? axis.values.size() - 1 : 0)) return "everywhere";
    const std::string at = terminal::CoordinateText(axis, *last);
    return boundaries.is_low ? "up to " + at : "from " + at + " on";
  }

  /// The others of the axes that move the boundary if nothing else changes.
  std::vector<std::size_t> AxesThatMove(const Boundaries& boundaries,
                                        const std::vector<std::size_t>& others) const {
    std::vector<std::size_t> moving;
    for (std::size_t i = 0; i < others.size(); ++i) {
      std::map<Point, std::set<std::optional<std::size_t>>> reached;
      for (const auto& [place, last] : boundaries.last) reached[Without(place, i)].insert(last);
      if (std::ranges::any_of(reached, [](const auto& each) { return each.second.size() > 1; }))
        moving.push_back(i);
    }
    return moving;
  }

  /// Where many lines stop being stable.
  std::string BoundaryText(std::size_t own, const std::map<Point, Line>& lines) const {
    const std::string along = AxisWords(file_.axes()[own]);
    auto boundaries = BoundariesOf(lines, true);
    if (!boundaries) boundaries = BoundariesOf(lines, false);
    if (!boundaries)
      return fmt::format(
          " Along {} there is no boundary: some cases are stable again beyond a value "
          "at which they are not.",
          along);
    const std::vector<std::size_t> others = OtherAxes(file_, own);
    const std::vector<std::size_t> moving = AxesThatMove(*boundaries, others);
    std::vector<std::string> names;
    for (const std::size_t i : moving) names.push_back(AxisWords(file_.axes()[others[i]]));
    if (moving.size() == 1) return TextBy(own, *boundaries, moving[0], others[moving[0]]);
    std::size_t nowhere = 0;
    std::optional<std::size_t> least, most;
    for (const auto& [place, last] : boundaries->last) {
      if (!last) {
        ++nowhere;
        continue;
      }
      const auto is_less = [&](std::size_t a, std::size_t b) {
        return boundaries->is_low ? a < b : a > b;
      };
      if (!least || is_less(*last, *least)) least = last;
      if (!most || is_less(*most, *last)) most = last;
    }
    std::string text = fmt::format(
        " Along {}: stable {} in the worst case, {} in the best{}", along,
        ReachText(own, *boundaries, nowhere > 0 ? std::nullopt : least),
        ReachText(own, *boundaries, most),
        nowhere > 0
            ? fmt::format(" ({} of {} cases are nowhere stable)", nowhere, boundaries->last.size())
            : "");
    return text + (names.empty() ? "." : fmt::format("; it depends on {}.", JoinWords(names)));
  }

  /// The boundary for each value of the only other axis that moves it; `place_at`: its position in
  /// a place.
  std::string TextBy(std::size_t own, const Boundaries& boundaries, std::size_t place_at,
                     std::size_t other) const {
    const plan::Axis& axis = file_.axes()[other];
    std::map<std::size_t, std::string> reached;
    for (const auto& [place, last] : boundaries.last)
      reached.emplace(place[place_at], ReachText(own, boundaries, last));
    std::vector<std::string> texts;
    for (auto begin = reached.begin(); begin != reached.end();) {
      auto end = std::next(begin);
      while (end != reached.end() && end->second == begin->second) ++end;
      const std::string from = terminal::CoordinateText(axis, begin->first);
      const std::string to = terminal::CoordinateText(axis, std::prev(end)->first);
      texts.push_back(fmt::format("{} with {} {}", begin->second, axis.name,
                                  from == to ? from : from + " .. " + to));
      begin = end;
    }
    return fmt::format(" Along {}: stable {}.", AxisWords(file_.axes()[own]), JoinWords(texts));
  }

  /// `stable 10 .. 90, tunnelled 120`.
  std::string TextOf(std::size_t own, const Line& line) const {
    const plan::Axis& axis = file_.axes()[own];
    std::string text;
    for (const Segment& segment : line)
      text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", segment.word,
                          terminal::CoordinateText(axis, segment.first),
                          segment.last > segment.first
                              ? " .. " + terminal::CoordinateText(axis, segment.last)
                              : "");
    return text;
  }

  /// The coordinates that the places have in common, and their number: ` with day storm (2 cases)`.
  std::string PlacesText(const std::vector<std::size_t>& axes,
                         const std::vector<Point>& places) const {
    std::vector<std::size_t> common;
    Point values;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const bool is_common =
          std::ranges::all_of(places, [&](const Point& place) { return place[i] == places[0][i]; });
      if (!is_common || file_.axes()[axes[i]].values.size() < 2) continue;
      common.push_back(axes[i]);
      values.push_back(places[0][i]);
    }
    const std::string text = PlaceText(file_, common, values);
    return (text.empty() ? text : " with " + text) +
           (places.size() > 1 ? fmt::format(" ({} cases)", places.size()) : "");
  }

  const results::ResultFile& file_;
  std::map<Point, std::string> verdicts_;
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

std::vector<Conclusion> Conclusions(const Model& model) {
  std::vector<Conclusion> all;
  ConcludeBudget(model, all);
  ConcludeErrors(model, all);
  ConcludeStep(model, all);
  ConcludeDetectors(model, all);
  ConcludeVerdicts(model, all);
  ConcludeAxes(model, all);
  ConcludeDetectorLimits(model, all);
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

/// Compares the first and the last value of an axis of numbers.
void AddScaling(const Model& model, std::size_t axis, std::vector<Conclusion>& all) {
  const plan::Axis& along = model.axis(axis);
  const Comparison comparison = CompareValues(model, axis, 0);
  if (comparison.is_void) return;
  std::vector<Estimate> ratios;
  const std::size_t last = along.values.size() - 1;
  for (const ComparedPoint& point : comparison.points) {
    const MeasuredPoint *from = point.values[0], *to = point.values[last];
    if (from == nullptr || to == nullptr || !from->IsSound() || !to->IsSound()) continue;
    if (auto ratio = comparison.RatioAt(point, last, Phase::kStep))
      ratios.push_back(*std::move(ratio));
  }
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
  all.push_back({fmt::format("Which {} has the shortest step?", AxisWords(along)),
                 std::move(answer), "scaling", ranking->certainty()});
}

/// The growth over all runs, if no detectors are compared.
void AddGrowthOfAll(const Model& model, std::vector<Conclusion>& all) {
  const auto growth = GrowthByRow(model, {});
  if (!growth || !growth->is_matched || growth->exponents.empty()) return;
  const DetectorGrowth::Exponent& exponent = growth->exponents.begin()->second;
  if (std::isnan(exponent.p)) return;
  all.push_back({"How does collision detection grow with the number of objects?",
                 fmt::format("As n^{:.2f} from {:.0f} to {:.0f} objects{}. The exponent is fitted, "
                             "without an interval.",
                             exponent.p, exponent.least, exponent.most,
                             growth->is_mean ? ", the mean over all other axes" : ""),
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
