#include "runtime/figures/searches/searches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "runtime/figures/bootstrap.h"
#include "runtime/figures/races/races.h"
#include "runtime/figures/requirements.h"
#include "runtime/terminal/table.h"

namespace cdb::searches {

namespace {

using figures::kNone;

double ValueAt(const plan::Axis& axis, std::size_t index) {
  return std::get<double>(axis.values[index]);
}

Point PointOf(const Line& line, std::size_t axis, std::size_t position) {
  Point at = line.place;
  at.insert(at.begin() + static_cast<std::ptrdiff_t>(axis), line.values[position]);
  return at;
}

Probe ProbeOf(const plan::Requirement& until, const figures::JudgedPoint& judged) {
  // A run without the figure crashed, or took too long: it counts as one whose figure is too large.
  const bool has_figure = !std::isnan(judged.value);
  const double value = has_figure ? judged.value : std::numeric_limits<double>::infinity();
  const bool is_sure = has_figure && (judged.answer == figures::Answer::kMet ||
                                      judged.answer == figures::Answer::kNotMet);
  const bool holds = is_sure ? judged.answer == figures::Answer::kMet
                             : plan::Holds(value, until.comparison, judged.limit);
  return {holds ? Probe::State::kYes : Probe::State::kNo, is_sure};
}

/// Sets the value of a boundary, and between which it is.
void SetValues(const plan::Axis& axis, Boundary& boundary) {
  const Bracket& bracket = boundary.bracket;
  const auto value_at = [&](std::size_t position) {
    return ValueAt(axis, boundary.line.values[position]);
  };
  double before = kNone, after = kNone;
  const std::size_t last = boundary.line.values.size() - 1;
  switch (bracket.outcome) {
    case Outcome::kNotKnown:
      return;
    case Outcome::kAtFirst:
      after = value_at(0);
      break;
    case Outcome::kNowhere:
      before = value_at(last);
      break;
    case Outcome::kBetween:
    case Outcome::kUncertain: {
      if (!bracket.HasNeighbours()) return;
      const double a = value_at(bracket.last_no), b = value_at(bracket.first_yes);
      boundary.value = axis.search->is_log ? std::sqrt(a * b) : (a + b) / 2;
      if (bracket.sure_no) before = value_at(*bracket.sure_no);
      if (bracket.sure_yes) after = value_at(*bracket.sure_yes);
      break;
    }
  }
  const bool descends = value_at(last) < value_at(0);
  boundary.low = descends ? after : before;
  boundary.high = descends ? before : after;
}

/// The points of a file that a search may run, and those all of whose repeats were run. Without
/// points with repeats of an earlier plan, the others of which were left out.
struct RunPoints {
  std::vector<Point> all;
  std::set<Point> complete;
};
RunPoints RunPointsOf(const results::ResultFile& file) {
  RunPoints points;
  for (const Point& at : figures::AllPoints(file)) {
    bool is_complete = true, is_left_out = false;
    for (std::uint64_t rep = 0; rep < file.repeats(); ++rep) {
      const results::Status status = file.ReadStatus({at, rep});
      is_complete = is_complete && status != results::Status::kMissing;
      is_left_out = is_left_out || status == results::Status::kSkipped;
    }
    if (is_left_out) continue;
    points.all.push_back(at);
    if (is_complete) points.complete.insert(at);
  }
  return points;
}

}  // namespace

std::vector<Line> LinesOf(std::size_t axis, const std::vector<Point>& points) {
  std::map<Point, std::vector<std::size_t>> by_place;
  for (const Point& at : points) by_place[figures::Without(at, axis)].push_back(at[axis]);
  std::vector<Line> lines;
  for (auto& [place, values] : by_place) {
    std::ranges::sort(values);
    lines.push_back({place, std::move(values)});
  }
  return lines;
}

std::vector<Boundary> FindBoundaries(const figures::Model& model) {
  const results::ResultFile& file = model.file();
  const auto axis = plan::SearchAxis(file.axes());
  if (!axis) return {};
  const plan::Requirement& until = model.axis(*axis).search->until;
  const RunPoints points = RunPointsOf(file);
  std::map<Point, Probe> probes;
  for (const figures::JudgedPoint& judged : figures::JudgePoints(model, until))
    if (points.complete.contains(judged.at)) probes.emplace(judged.at, ProbeOf(until, judged));
  std::vector<Boundary> boundaries;
  for (Line& line : LinesOf(*axis, points.all)) {
    std::vector<Probe> states;
    for (std::size_t i = 0; i < line.values.size(); ++i) {
      const auto found = probes.find(PointOf(line, *axis, i));
      states.push_back(found == probes.end() ? Probe{} : found->second);
    }
    Boundary boundary;
    boundary.bracket = Locate(states);
    boundary.line = std::move(line);
    SetValues(model.axis(*axis), boundary);
    boundaries.push_back(std::move(boundary));
  }
  return boundaries;
}

std::vector<Point> NextPoints(std::size_t axis, const std::vector<Boundary>& boundaries) {
  std::vector<Point> next;
  for (const Boundary& boundary : boundaries)
    for (const std::size_t position : boundary.bracket.next)
      next.push_back(PointOf(boundary.line, axis, position));
  std::ranges::sort(next);
  return next;
}

namespace {

std::vector<Line> PlannedLines(const plan::Plan& plan, std::size_t axis) {
  std::vector<Point> points;
  plan.ForEachRun([&](const std::string&, const Point& at, std::uint64_t rep) {
    if (rep == 0) points.push_back(at);
  });
  return LinesOf(axis, points);
}

}  // namespace

std::vector<Point> FirstPoints(const plan::Plan& plan) {
  const auto axis = plan.SearchAxis();
  if (!axis) return {};
  std::vector<Boundary> boundaries;
  for (Line& line : PlannedLines(plan, *axis)) {
    Boundary boundary;
    boundary.bracket = Locate(std::vector<Probe>(line.values.size()));
    boundary.line = std::move(line);
    boundaries.push_back(std::move(boundary));
  }
  return NextPoints(*axis, boundaries);
}

std::uint64_t ExpectedRuns(const plan::Plan& head, std::uint64_t runs) {
  const auto axis = head.SearchAxis();
  if (!axis) return runs;  // a race may need all
  const std::uint64_t values = head.axes[*axis].values.size();
  const std::uint64_t lines = (runs + values * head.repeats - 1) / (values * head.repeats);
  return std::min(runs, lines * UsualProbes(values) * head.repeats);
}

std::string RunsText(const plan::Plan& head, std::uint64_t runs) {
  const std::string all = fmt::format("{} run{}", runs, runs == 1 ? "" : "s");
  if (!head.RaceAxes().empty())
    return fmt::format("a race: {} to {}", races::LeastRuns(head, runs), all);
  return head.SearchAxis() ? fmt::format("a search: about {} of {}", ExpectedRuns(head, runs), all)
                           : all;
}

namespace {

/// The axis whose values are seeds, unless they are searched.
std::optional<std::size_t> SeedAxis(const std::vector<plan::Axis>& axes) {
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (axes[i].parameter == "seed" && !axes[i].search) return i;
  return std::nullopt;
}

/// Sets value and interval over several seeds.
void PoolValues(bool is_log, PooledBoundary& pooled) {
  std::vector<double> values;
  // How far each boundary may be below and above its value; and the range of all.
  double below = 0, above = 0, low = std::numeric_limits<double>::infinity(), high = -low;
  const auto place = [is_log](double x) { return is_log ? std::log(x) : x; };
  for (const Boundary* one : pooled.searches) {
    if (!one->IsFound()) continue;
    values.push_back(place(one->value));
    below += place(one->value) - place(one->low);
    above += place(one->high) - place(one->value);
    // A range reaches as far as its searches do not tell.
    low = std::isnan(low) || std::isnan(one->low) ? kNone : std::min(low, one->low);
    high = std::isnan(high) || std::isnan(one->high) ? kNone : std::max(high, one->high);
  }
  pooled.kind = figures::IntervalKind::kRange;
  if (values.empty()) return;
  pooled.interval = {low, high};
  if (pooled.found < pooled.searches.size()) return;
  const figures::Bootstrap bootstrap(values.size());
  const figures::Estimate mean = bootstrap.MeanEstimate(values);
  const auto back = [is_log](double x) { return is_log ? std::exp(x) : x; };
  pooled.value = back(mean.value);
  pooled.kind = bootstrap.kind();
  if (pooled.kind != figures::IntervalKind::kInterval) return;
  const figures::Interval interval = bootstrap.IntervalOf(mean);
  const auto count = static_cast<double>(values.size());
  pooled.interval = {back(interval.low - below / count), back(interval.high + above / count)};
}

}  // namespace

std::vector<std::size_t> PooledAxes(const results::ResultFile& file) {
  std::vector<std::size_t> axes;
  const auto search = plan::SearchAxis(file.axes()), seed = SeedAxis(file.axes());
  for (std::size_t i = 0; i < file.axes().size(); ++i)
    if (i != search && i != seed) axes.push_back(i);
  return axes;
}

std::vector<PooledBoundary> Pool(const results::ResultFile& file,
                                 const std::vector<Boundary>& boundaries) {
  const auto axis = plan::SearchAxis(file.axes());
  if (!axis) return {};
  auto seed = SeedAxis(file.axes());
  if (seed && *seed > *axis) --*seed;  // places are without the axis of the search
  std::map<Point, PooledBoundary> by_place;
  for (const Boundary& one : boundaries) {
    const Point place = seed ? figures::Without(one.line.place, *seed) : one.line.place;
    PooledBoundary& pooled = by_place[place];
    pooled.place = place;
    pooled.searches.push_back(&one);
    pooled.found += one.IsFound();
    pooled.probes += one.bracket.probes;
    pooled.not_monotone += one.bracket.IsMonotone() ? 0 : 1;
  }
  const bool is_log = file.axes()[*axis].search->is_log;
  std::vector<PooledBoundary> all;
  for (auto& [place, pooled] : by_place) {
    if (pooled.searches.size() > 1) {
      PoolValues(is_log, pooled);
    } else {
      pooled.value = pooled.searches[0]->value;
      pooled.interval = {pooled.searches[0]->low, pooled.searches[0]->high};
    }
    all.push_back(std::move(pooled));
  }
  return all;
}

namespace {

std::string NumberText(double value) { return terminal::ShortNumber(value); }

/// `12 .. 15`, `below 15`, `above 12`; empty if nothing is known.
std::string RangeText(const figures::Interval& range) {
  const bool has_low = !std::isnan(range.low), has_high = !std::isnan(range.high);
  if (has_low && has_high)
    return fmt::format("{} .. {}", NumberText(range.low), NumberText(range.high));
  if (has_low) return "above " + NumberText(range.low);
  return has_high ? "below " + NumberText(range.high) : "";
}

}  // namespace

std::string BoundaryText(const plan::Axis& axis, const PooledBoundary& of) {
  const auto count = [&](Outcome outcome) {
    return std::ranges::count(of.searches, outcome,
                              [](const Boundary* one) { return one->bracket.outcome; });
  };
  const std::size_t all = of.searches.size();
  if (count(Outcome::kNotKnown) > 0) return "not known: runs are missing";
  const std::string first = NumberText(ValueAt(axis, of.searches[0]->line.values.front())),
                    last = NumberText(ValueAt(axis, of.searches[0]->line.values.back()));
  const auto nowhere = static_cast<std::size_t>(count(Outcome::kNowhere)),
             at_first = static_cast<std::size_t>(count(Outcome::kAtFirst));
  if (nowhere == all) return fmt::format("nowhere up to {}", last);
  if (at_first == all) return fmt::format("at {} already", first);
  const std::string range = RangeText(of.interval);
  if (of.found == 0 && nowhere + at_first == 0)
    return of.searches[0]->bracket.starts_with_yes
               ? fmt::format("cannot tell, may be at {} already", first)
               : fmt::format("cannot tell, may be nowhere up to {}", last);
  if (of.found < all) {
    std::string text = fmt::format("in {} of {} seeds", of.found, all);
    if (!range.empty()) text += ", " + range;
    if (nowhere > 0) text += fmt::format("; nowhere up to {} in {}", last, nowhere);
    if (at_first > 0) text += fmt::format("; at {} already in {}", first, at_first);
    return text;
  }
  std::string text = NumberText(of.value);
  if (!range.empty()) text += fmt::format(" ({})", range);
  return text;
}

results::StoredAnswers AnswersToStore(const std::filesystem::path& path) {
  const results::ResultFile file(path, results::ProofOf::kStructure);
  const figures::Model model(file);
  results::StoredAnswers stored = figures::AnswersOf(model);
  if (const std::vector<races::PlacedRace> raced = races::RunRaces(file); !raced.empty()) {
    stored.races = races::RacesToStore(file, raced);
    stored.has_all_runs = races::NextCells(raced).empty();
  }
  const auto axis = plan::SearchAxis(file.axes());
  if (!axis) return stored;
  const std::vector<Boundary> boundaries = FindBoundaries(model);
  stored.has_all_runs = NextPoints(*axis, boundaries).empty();
  std::map<Point, std::size_t> places;
  for (const Point& at : figures::AllPoints(file))
    places.emplace(figures::Without(at, *axis), places.size());
  const std::size_t count = places.size();
  stored.boundaries = {std::vector<double>(count, 0),     std::vector<double>(count, kNone),
                       std::vector<double>(count, kNone), std::vector<double>(count, kNone),
                       std::vector<double>(count, 0),     std::vector<double>(count, 0)};
  for (const Boundary& one : boundaries) {
    const std::size_t at = places.at(one.line.place);
    stored.boundaries.outcome[at] = static_cast<double>(one.bracket.outcome);
    stored.boundaries.value[at] = one.value;
    stored.boundaries.low[at] = one.low;
    stored.boundaries.high[at] = one.high;
    stored.boundaries.changes[at] = static_cast<double>(one.bracket.changes);
    stored.boundaries.probes[at] = static_cast<double>(one.bracket.probes);
  }
  return stored;
}

}  // namespace cdb::searches
