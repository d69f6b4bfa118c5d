#include "runtime/figures/races/races.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "compiler/plan/race.h"
#include "compiler/plan/race_bounds.h"
#include "compiler/schema/series.h"
#include "runtime/figures/times.h"
#include "runtime/terminal/table.h"

namespace cdb::races {
namespace {

bool WasRun(results::Status status) {
  return status != results::Status::kMissing && status != results::Status::kSkipped;
}

/// Reads the time of a run by which a race is decided.
class TimeReader {
 public:
  TimeReader(const results::ResultFile& file, const plan::Figure& by) : file_(file) {
    const auto names = figures::CycleStatisticNames();
    statistic_ = static_cast<figures::CycleStatistic>(std::ranges::find(names, by.statistic) -
                                                      names.begin());
    phase_ = static_cast<protocol::Phase>(std::ranges::find(schema::kPhases, by.name) -
                                          std::begin(schema::kPhases));
  }

  /// As of Times.
  double Of(const Cell& cell) const {
    if (!WasRun(file_.ReadStatus(cell))) return figures::kNone;
    if (figures::Trouble(file_, cell)) return std::numeric_limits<double>::infinity();
    const double time = figures::StatisticOf(file_.ReadDuration(phase_, cell), statistic_);
    return time > 0 ? time : std::numeric_limits<double>::infinity();
  }

 private:
  const results::ResultFile& file_;
  figures::CycleStatistic statistic_;
  protocol::Phase phase_;
};

/// True if the point has runs: `skip` left out none of its repeats.
bool HasRuns(const results::ResultFile& file, const Point& at) {
  for (std::uint64_t rep = 0; rep < file.repeats(); ++rep)
    if (file.ReadStatus({at, rep}) != results::Status::kSkipped) return true;
  return false;
}

/// The index of a racer among all combinations of the values of the axes with a race.
std::size_t IndexOf(const std::vector<plan::Axis>& axes, const Point& racer) {
  std::size_t index = 0;
  for (const std::size_t axis : plan::RaceAxes(axes))
    index = index * axes[axis].values.size() + racer[axis];
  return index;
}

}  // namespace

std::vector<std::size_t> PlacedRace::With(Outcome outcome) const {
  std::vector<std::size_t> with;
  for (std::size_t i = 0; i < racers.size(); ++i)
    if (race.standings[i].outcome == outcome) with.push_back(i);
  std::ranges::stable_sort(with, {}, [&](std::size_t i) {
    const Standing& standing = race.standings[i];
    if (std::isnan(standing.ratio)) return std::numeric_limits<double>::infinity();
    return standing.against == i ? 0 : standing.ratio;
  });
  return with;
}

std::vector<std::size_t> PlaceAxes(const std::vector<plan::Axis>& axes) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (!axes[i].race) others.push_back(i);
  return others;
}

std::vector<PlacedRace> RunRaces(const results::ResultFile& file) {
  const std::vector<std::size_t> raced = plan::RaceAxes(file.axes());
  if (raced.empty()) return {};
  const std::vector<std::size_t> others = PlaceAxes(file.axes());
  const plan::Race& rules = *file.axes()[raced[0]].race;
  std::map<Point, std::vector<Point>> by_place;
  for (const Point& at : figures::AllPoints(file))
    if (HasRuns(file, at)) by_place[figures::Project(at, others)].push_back(at);
  const TimeReader reader(file, rules.by);
  std::vector<PlacedRace> races;
  for (auto& [place, racers] : by_place) {
    Times times;
    for (const Point& at : racers) {
      times.emplace_back();
      for (std::uint64_t rep = 0; rep < file.repeats(); ++rep)
        times.back().push_back(reader.Of({at, rep}));
    }
    const plan::RaceBounds bounds(racers.size(), file.repeats());
    races.push_back({place, std::move(racers), RunRace(times, bounds, rules.tolerance)});
  }
  return races;
}

std::vector<Cell> NextCells(const std::vector<PlacedRace>& races) {
  std::vector<Cell> next;
  for (const PlacedRace& of : races)
    for (const auto& [racer, rep] : of.race.next) next.push_back({of.racers[racer], rep});
  std::ranges::sort(next, {}, [](const Cell& cell) { return std::pair(cell.at, cell.rep); });
  return next;
}

results::StoredAnswers::Races RacesToStore(const results::ResultFile& file,
                                           const std::vector<PlacedRace>& races) {
  const std::vector<Point> points = figures::AllPoints(file);
  const auto all = [&](double value) { return std::vector<double>(points.size(), value); };
  results::StoredAnswers::Races stored = {
      all(0), all(-1), all(-1), all(figures::kNone), all(figures::kNone), all(figures::kNone)};
  std::map<Point, std::size_t> places;
  for (const Point& at : points) places.emplace(at, places.size());
  for (const PlacedRace& of : races)
    for (std::size_t i = 0; i < of.racers.size(); ++i) {
      const std::size_t at = places.at(of.racers[i]);
      const Standing& standing = of.race.standings[i];
      stored.outcome[at] = static_cast<double>(standing.outcome);
      if (standing.outcome == Outcome::kNotKnown) continue;
      stored.repeats[at] = static_cast<double>(standing.repeats);
      stored.against[at] = static_cast<double>(IndexOf(file.axes(), of.racers[standing.against]));
      stored.ratio[at] = standing.ratio;
      stored.low[at] = standing.bounds.low;
      stored.high[at] = standing.bounds.high;
    }
  return stored;
}

std::uint64_t LeastRuns(const plan::Plan& head, std::uint64_t runs) {
  std::size_t racers = 1;
  for (const std::size_t axis : head.RaceAxes()) racers *= head.axes[axis].values.size();
  return runs / head.repeats * plan::LeastRaceRepeats(racers);
}

std::string RacerText(const results::ResultFile& file, const Point& racer) {
  const std::vector<std::size_t> axes = plan::RaceAxes(file.axes());
  if (axes.size() == 1) return terminal::CoordinateText(file.axes()[axes[0]], racer[axes[0]]);
  return fmt::format("({})", figures::PlaceText(file, axes, figures::Project(racer, axes)));
}

std::string_view OutcomeName(Outcome outcome) {
  constexpr std::string_view kNames[] = {"not_known", "won", "dropped", "tied", "open", "failed"};
  return kNames[static_cast<std::size_t>(outcome)];
}

std::string OutcomeText(const results::ResultFile& file, const PlacedRace& race,
                        std::size_t racer) {
  const Standing& standing = race.race.standings[racer];
  const std::string against = RacerText(file, race.racers[standing.against]);
  switch (standing.outcome) {
    case Outcome::kNotKnown:
      return "not known: runs are missing";
    case Outcome::kWon:
      return "won";
    case Outcome::kDropped:
      return "slower than " + against;
    case Outcome::kTied:
      return racer == race.race.leader ? "tied" : "tied with " + against;
    case Outcome::kOpen:
      return racer == race.race.leader ? "too close to call"
                                       : "cannot be told apart from " + against;
    case Outcome::kFailed:
      return "failed";
  }
  return {};
}

std::string RatioText(const PlacedRace& race, std::size_t racer) {
  const Standing& standing = race.race.standings[racer];
  if (std::isnan(standing.ratio) || standing.against == racer) return {};
  // A bound close to 1 shows on which side it is.
  const auto text = [](double ratio) {
    return std::fabs(ratio - 1) < 0.1 ? fmt::format("{:.4f}", ratio) : terminal::ShortNumber(ratio);
  };
  std::string all = text(standing.ratio);
  if (!std::isnan(standing.bounds.low))
    all += fmt::format(" ({} .. {})", text(standing.bounds.low), text(standing.bounds.high));
  return all;
}

namespace {

/// `grid is 1.0093 (1.0025 .. 1.0388) times as slow`: the one that is the nearest to the winner.
std::string NextText(const results::ResultFile& file, const PlacedRace& of, std::size_t winner) {
  for (const std::size_t i : of.With(Outcome::kDropped))
    if (of.race.standings[i].against == winner)
      return fmt::format(" Next is {}, with {} times its time.", RacerText(file, of.racers[i]),
                         RatioText(of, i));
  return {};
}

/// The winner; those that are left, if nobody won.
std::string FastestText(const results::ResultFile& file, const PlacedRace& of) {
  if (!of.race.HasEnded()) return "not known, as runs are missing";
  for (const Outcome outcome : {Outcome::kWon, Outcome::kTied, Outcome::kOpen}) {
    std::vector<std::string> names;
    for (const std::size_t i : of.With(outcome)) names.push_back(RacerText(file, of.racers[i]));
    if (names.empty()) continue;
    return figures::JoinWords(names) + (outcome == Outcome::kTied   ? ", which are tied"
                                        : outcome == Outcome::kOpen ? ", too close to call"
                                                                    : "");
  }
  return "none, as all failed";
}

}  // namespace

figures::Conclusion ConcludeRaces(const results::ResultFile& file,
                                  const std::vector<PlacedRace>& races) {
  const std::vector<std::size_t> raced = plan::RaceAxes(file.axes()),
                                 others = PlaceAxes(file.axes());
  std::vector<std::string> names;
  for (const std::size_t axis : raced) names.push_back(file.axes()[axis].name);
  figures::Conclusion conclusion = {
      fmt::format("Which {}{} has the least {}?", raced.size() > 1 ? "combination of " : "",
                  figures::JoinWords(names), file.axes()[raced[0]].race->by.Text()),
      {},
      "race",
      figures::Certainty::kClear};
  std::map<std::string, std::vector<const PlacedRace*>> by_text;
  std::size_t won = 0, unfinished = 0;
  for (const PlacedRace& of : races) {
    by_text[FastestText(file, of)].push_back(&of);
    won += of.race.HasEnded() && !of.With(Outcome::kWon).empty();
    unfinished += !of.race.HasEnded();
  }
  if (won < races.size())
    conclusion.certainty = unfinished > 0 ? figures::Certainty::kUnknown : figures::Certainty::kTie;
  std::vector<std::pair<std::string, std::vector<const PlacedRace*>>> all(by_text.begin(),
                                                                          by_text.end());
  std::ranges::stable_sort(all, std::greater<>{}, [](const auto& of) { return of.second.size(); });
  std::string& answer = conclusion.answer;
  constexpr std::size_t kMostTexts = 4;
  for (std::size_t i = 0; i < std::min(all.size(), kMostTexts); ++i) {
    const auto& [text, alike] = all[i];
    answer += i == 0 ? "" : "; ";
    answer += races.size() == 1 ? text
              : alike.size() == 1
                  ? fmt::format("{} at {}", text, figures::PlaceText(file, others, alike[0]->place))
                  : fmt::format("{} in {} of {} races", text, alike.size(), races.size());
  }
  answer += all.size() > kMostTexts ? "; others elsewhere." : ".";
  if (races.size() == 1 && won == 1)
    answer += NextText(file, races[0], races[0].With(Outcome::kWon)[0]);
  return conclusion;
}

}  // namespace cdb::races
