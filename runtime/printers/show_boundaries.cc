// The boundaries that the searches of a scenario (`find( )`) found.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "runtime/figures/searches/searches.h"
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

}  // namespace cdb::printers
