// The boundaries that the searches of a scenario (`find( )`) found.

#include <fmt/format.h>

#include <string>
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
  std::string interval;
  for (const searches::PooledBoundary& of : all) {
    not_monotone += of.not_monotone;
    searches += of.searches.size();
    probes += of.probes;
    if (of.kind != figures::IntervalKind::kAbsent) interval = figures::NameOf(of.kind);
    for (const searches::Boundary* one : of.searches)
      uncertain += one->bracket.outcome == searches::Outcome::kUncertain;
  }
  std::vector<std::string> notes = {fmt::format(
      "{} of {} points were run. In brackets: the {}.", probes,
      figures::AllPoints(model.file()).size(),
      interval.empty() ? "two values between which it is" : interval + " over the seeds")};
  if (not_monotone > 0)
    notes.push_back(fmt::format(
        "In {} of {} searches the condition is met, and then not met again, further along {}: the "
        "first boundary is given, and there are others.",
        not_monotone, searches, axis));
  if (uncertain > 0)
    notes.push_back(fmt::format(
        "In {} of {} searches, runs around the boundary do not tell whether the condition is met: "
        "more `repeats` narrow it down.",
        uncertain, searches));
  return notes;
}

/// `verdict != stable along ratio`.
std::string TitleOf(const plan::Axis& searched) {
  return fmt::format("{} along {}", searched.search->until.text, searched.name);
}

}  // namespace

void AddBoundaries(const figures::Model& model, Document& document) {
  const auto axis = searches::SearchAxis(model.file().axes());
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
  if (const auto axis = searches::SearchAxis(file.axes()))
    document.front().title = fmt::format("{}: {}", file.title(), TitleOf(file.axes()[*axis]));
  return TextOf(document, Format::kTerminal);
}

}  // namespace cdb::printers
