// What the searches (`find( )`) and the races (`race( )`) of a scenario found.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "compiler/plan/race_bounds.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/races/races.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/printers/json_points.h"
#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

/// What a reader has to know before trusting the boundaries.
std::vector<std::string> Notes(const figures::Model& model,
                               const std::vector<searches::PooledBoundary>& all,
                               const std::string& axis) {
  std::size_t not_monotone = 0, searches = 0, uncertain = 0, probes = 0;
  figures::IntervalKind kind = figures::IntervalKind::kAbsent;
  for (const searches::PooledBoundary& of : all) {
    not_monotone += of.not_monotone;
    searches += of.searches.size();
    probes += of.probes;
    kind = std::max(kind, of.kind);
    for (const searches::Boundary* one : of.searches)
      uncertain += one->bracket.outcome == searches::Outcome::kUncertain;
  }
  std::vector<std::string> notes = {
      fmt::format("{} of {} points were run. In brackets: the {}.", probes,
                  figures::AllPoints(model.file()).size(),
                  kind == figures::IntervalKind::kAbsent
                      ? "two values between which it is"
                      : fmt::format("{} over the seeds", figures::NameOf(kind)))};
  if (not_monotone > 0)
    notes.push_back(fmt::format(
        "In {} of {} searches the condition is met, and then not met again, further along {}: the "
        "first boundary is given, and there are others.",
        not_monotone, searches, axis));
  const plan::Axis& searched = model.axis(*plan::SearchAxis(model.file().axes()));
  if (uncertain > 0)
    notes.push_back(fmt::format(
        "In {} of {} searches, runs that decide do not tell whether the condition is met: {}.",
        uncertain, searches,
        searched.search->until.figure.IsMeasured() ? "more `repeats` may narrow it down"
                                                   : "they failed, or do not have the figure"));
  return notes;
}

/// `verdict != stable along ratio`.
std::string TitleOf(const plan::Axis& searched) {
  return fmt::format("{} along {}", searched.search->until.text, searched.name);
}

/// The boundaries of a file by the labels of their places.
class BoundariesByPlace {
 public:
  explicit BoundariesByPlace(const results::ResultFile& file)
      : model_(file),
        boundaries_(searches::FindBoundaries(model_)),
        pooled_(searches::Pool(file, boundaries_)) {
    const std::vector<std::size_t> axes = searches::PooledAxes(file);
    for (const searches::PooledBoundary& of : pooled_) {
      std::vector<std::string> place;
      for (std::size_t i = 0; i < axes.size(); ++i)
        place.push_back(fmt::format("{} {}", model_.axis(axes[i]).name,
                                    terminal::CoordinateText(model_.axis(axes[i]), of.place[i])));
      places_.emplace_back(fmt::format("{}", fmt::join(place, ", ")), &of);
    }
  }

  const auto& places() const { return places_; }
  const searches::PooledBoundary* Find(const std::string& place) const {
    const auto found = std::ranges::find(places_, place, [](const auto& of) { return of.first; });
    return found == places_.end() ? nullptr : found->second;
  }

 private:
  const figures::Model model_;
  const std::vector<searches::Boundary> boundaries_;
  const std::vector<searches::PooledBoundary> pooled_;
  std::vector<std::pair<std::string, const searches::PooledBoundary*>> places_;
};

/// `moved`, if the two surely differ; `moved by a factor of 1.8` if their values are known.
std::string ChangeText(const searches::PooledBoundary& a, const searches::PooledBoundary& b) {
  const auto is_below = [](const searches::PooledBoundary& of,
                           const searches::PooledBoundary& other) {
    return of.interval.high < other.interval.low;
  };
  if (!is_below(a, b) && !is_below(b, a)) return "no change that shows";
  if (std::isnan(a.value) || std::isnan(b.value) || a.value * b.value <= 0) return "moved";
  return fmt::format("moved by a factor of {}", terminal::ShortNumber(b.value / a.value));
}

}  // namespace

Section BoundaryChanges(const results::ResultFile& a, const results::ResultFile& b) {
  Section section;
  const auto in_a = plan::SearchAxis(a.axes()), in_b = plan::SearchAxis(b.axes());
  if (!in_a || !in_b) return section;
  const plan::Axis &axis_a = a.axes()[*in_a], &axis_b = b.axes()[*in_b];
  if (axis_a.name != axis_b.name || !axis_a.search->until.IsSame(axis_b.search->until))
    return section;
  section.title = "Where " + TitleOf(axis_a);
  for (const char* head : {"where", "from", "to", "change"}) section.table.AddColumn(head, false);
  const BoundariesByPlace of_a(a), of_b(b);
  for (const auto& [place, before] : of_a.places())
    if (const searches::PooledBoundary* after = of_b.Find(place))
      section.table.rows.push_back(
          {place.empty() ? "the only one" : place, searches::BoundaryText(axis_a, *before),
           searches::BoundaryText(axis_b, *after), ChangeText(*before, *after)});
  return section;
}

void AddBoundaries(const figures::Model& model, Document& document) {
  const auto axis = plan::SearchAxis(model.file().axes());
  if (!axis) return;
  const std::vector<searches::Boundary> boundaries = searches::FindBoundaries(model);
  const std::vector<searches::PooledBoundary> all = searches::Pool(model.file(), boundaries);
  const plan::Axis& searched = model.axis(*axis);
  Section section = {.title = "Where " + TitleOf(searched)};
  const std::vector<std::size_t> axes = searches::PooledAxes(model.file());
  for (const std::size_t i : axes)
    section.table.AddColumn(model.axis(i).name, !model.axis(i).IsText());
  section.table.AddColumn(
      searched.unit.empty() ? searched.name : fmt::format("{} ({})", searched.name, searched.unit),
      false);
  section.table.AddColumn("points run", true);
  for (const searches::PooledBoundary& of : all) {
    std::vector<std::string> row;
    for (std::size_t i = 0; i < axes.size(); ++i)
      row.push_back(terminal::CoordinateText(model.axis(axes[i]), of.place[i]));
    row.push_back(searches::BoundaryText(searched, of));
    row.push_back(fmt::format("{}", of.probes));
    section.table.rows.push_back(std::move(row));
  }
  section.notes = Notes(model, all, searched.name);
  document.push_back(std::move(section));
}

std::string BoundariesText(const results::ResultFile& file) {
  const figures::Model model(file);
  Document document;
  AddBoundaries(model, document);
  if (const auto axis = plan::SearchAxis(file.axes()))
    document.front().title = fmt::format("{}: {}", file.title(), TitleOf(file.axes()[*axis]));
  return TextOf(document, Format::kTerminal);
}

Json DocumentBoundaries(const figures::Model& model) {
  const std::vector<searches::Boundary> boundaries = searches::FindBoundaries(model);
  if (boundaries.empty()) return nullptr;
  const std::size_t axis = *plan::SearchAxis(model.file().axes());
  const std::vector<std::size_t> axes = searches::PooledAxes(model.file());
  Json all = Json::array(), names = Json::array();
  for (const std::size_t i : axes) names.push_back(model.axis(i).name);
  for (const searches::PooledBoundary& of : searches::Pool(model.file(), boundaries))
    all.push_back({{"place", PlaceJson(model, axes, of.place)},
                   {"at", of.place},
                   {"value", JsonNumber(of.value, 9)},
                   {"low", JsonNumber(of.interval.low, 9)},
                   {"high", JsonNumber(of.interval.high, 9)},
                   {"interval", figures::NameOf(of.kind)},
                   {"searches", of.searches.size()},
                   {"found", of.found},
                   {"probes", of.probes},
                   {"not_monotone", of.not_monotone},
                   {"text", searches::BoundaryText(model.axis(axis), of)}});
  return {{"axis", model.axis(axis).name},
          {"until", model.axis(axis).search->until.text},
          {"log", model.axis(axis).search->is_log},
          {"values", model.axis(axis).values.size()},
          {"axes", std::move(names)},
          {"boundaries", std::move(all)}};
}

namespace {

using races::Outcome;
using races::PlacedRace;

/// In this order in a table.
constexpr Outcome kOrder[] = {Outcome::kWon,     Outcome::kTied,   Outcome::kOpen,
                              Outcome::kDropped, Outcome::kFailed, Outcome::kNotKnown};

/// The racers in this order.
std::vector<std::size_t> InOrder(const PlacedRace& race) {
  std::vector<std::size_t> all;
  for (const Outcome outcome : kOrder)
    std::ranges::copy(race.With(outcome), std::back_inserter(all));
  return all;
}

/// The number of races that somebody won, that are tied, too close to call, and unfinished.
std::string SummaryOf(const std::vector<PlacedRace>& all) {
  std::size_t won = 0, tied = 0, open = 0, unfinished = 0, failed = 0;
  for (const PlacedRace& of : all) {
    if (!of.race.HasEnded())
      ++unfinished;
    else if (!of.With(Outcome::kWon).empty())
      ++won;
    else if (!of.With(Outcome::kTied).empty())
      ++tied;
    else if (!of.With(Outcome::kOpen).empty())
      ++open;
    else
      ++failed;
  }
  std::vector<std::string> parts;
  const auto add = [&parts](std::size_t count, const char* what) {
    if (count > 0) parts.push_back(fmt::format("{} {}", count, what));
  };
  add(won, "won");
  add(tied, "tied");
  add(open, "too close to call");
  add(failed, "in which every configuration failed");
  add(unfinished, "not finished");
  return fmt::format("{} race{}: {}.", all.size(), all.size() == 1 ? "" : "s",
                     fmt::join(parts, ", "));
}

std::vector<std::string> RaceNotes(const figures::Model& model,
                                   const std::vector<PlacedRace>& all) {
  const figures::CellGroups& runs = model.runs();
  const std::size_t done = runs.good.size() + runs.bad.size();
  std::size_t planned = 0;
  for (const PlacedRace& of : all) planned += of.racers.size() * model.file().repeats();
  return {fmt::format("{} {} of {} runs were executed.", SummaryOf(all), done, planned),
          fmt::format("Ratio: the median over the repeats of both, and bounds of it. A race drops "
                      "its fastest configuration with a probability of at most {:g} %.",
                      100 * plan::kRaceError)};
}

}  // namespace

std::vector<figures::Conclusion> ConclusionsOf(const figures::Model& model) {
  std::vector<figures::Conclusion> all = figures::Conclusions(model);
  if (const std::vector<PlacedRace> raced = races::RunRaces(model.file()); !raced.empty())
    all.insert(all.begin(), races::ConcludeRaces(model.file(), raced));
  return all;
}

void AddRaces(const figures::Model& model, Document& document) {
  const std::vector<PlacedRace> all = races::RunRaces(model.file());
  if (all.empty()) return;
  const std::vector<std::size_t> raced = plan::RaceAxes(model.file().axes()),
                                 others = races::PlaceAxes(model.file().axes());
  std::vector<std::string> names;
  for (const std::size_t i : raced) names.push_back(model.axis(i).name);
  Section section = {.title = fmt::format("Race of {} by {}", fmt::join(names, ", "),
                                          model.axis(raced[0]).race->by.Text())};
  for (const auto& axes : {others, raced})
    for (const std::size_t i : axes)
      section.table.AddColumn(model.axis(i).name, !model.axis(i).IsText());
  section.table.AddColumn("outcome", false);
  section.table.AddColumn("repeats", true);
  section.table.AddColumn("ratio", false);
  for (const PlacedRace& of : all)
    for (const std::size_t i : InOrder(of)) {
      std::vector<std::string> row;
      for (const auto& axes : {others, raced})
        for (const std::size_t axis : axes)
          row.push_back(terminal::CoordinateText(model.axis(axis), of.racers[i][axis]));
      row.push_back(races::OutcomeText(model.file(), of, i));
      row.push_back(fmt::format("{}", of.race.standings[i].repeats));
      row.push_back(races::RatioText(of, i));
      section.table.rows.push_back(std::move(row));
    }
  section.notes = RaceNotes(model, all);
  document.push_back(std::move(section));
}

Json DocumentRaces(const figures::Model& model) {
  const results::ResultFile& file = model.file();
  const std::vector<PlacedRace> placed = races::RunRaces(file);
  if (placed.empty()) return nullptr;
  const std::vector<std::size_t> raced = plan::RaceAxes(file.axes()),
                                 others = races::PlaceAxes(file.axes());
  Json all = Json::array();
  for (const PlacedRace& of : placed) {
    Json racers = Json::array();
    for (const std::size_t i : InOrder(of)) {
      const races::Standing& standing = of.race.standings[i];
      const bool is_known = standing.outcome != Outcome::kNotKnown;
      racers.push_back(
          {{"racer", races::RacerText(file, of.racers[i])},
           {"at", of.racers[i]},
           {"outcome", races::OutcomeName(standing.outcome)},
           {"repeats", standing.repeats},
           {"against",
            is_known ? Json(races::RacerText(file, of.racers[standing.against])) : Json()},
           {"ratio", JsonNumber(standing.ratio, 9)},
           {"low", JsonNumber(standing.bounds.low, 9)},
           {"high", JsonNumber(standing.bounds.high, 9)},
           {"text", races::OutcomeText(file, of, i)},
           {"ratio_text", races::RatioText(of, i)}});
    }
    all.push_back({{"place", PlaceJson(model, others, of.place)},
                   {"at", of.place},
                   {"ended", of.race.HasEnded()},
                   {"racers", std::move(racers)}});
  }
  const auto names = [&](const std::vector<std::size_t>& axes) {
    Json list = Json::array();
    for (const std::size_t i : axes) list.push_back(model.axis(i).name);
    return list;
  };
  return {{"by", model.axis(raced[0]).race->by.Text()},
          {"tolerance", model.axis(raced[0]).race->tolerance},
          {"axes", names(raced)},
          {"others", names(others)},
          {"notes", RaceNotes(model, placed)},
          {"races", std::move(all)}};
}

}  // namespace cdb::printers
