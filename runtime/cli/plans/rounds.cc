#include "runtime/cli/plans/rounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/model.h"
#include "runtime/figures/races/races.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/results/journal/merge.h"

namespace cdb::plans {

namespace fs = std::filesystem;

namespace {

using Cell = figures::Cell;

/// The ids of these runs. `cells`: in grid order, repeats innermost.
std::vector<std::string> IdsOf(const plan::Plan& plan, const std::vector<Cell>& cells) {
  const auto key = [](const Cell& cell) { return std::tie(cell.at, cell.rep); };
  std::vector<std::string> ids;
  plan.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
    if (std::ranges::binary_search(cells, std::tie(at, rep), {}, key)) ids.push_back(id);
  });
  return ids;
}

/// All repeats of these points.
std::vector<Cell> CellsOf(const std::vector<figures::Point>& points, std::uint64_t repeats) {
  std::vector<Cell> cells;
  for (const figures::Point& at : points)
    for (std::uint64_t rep = 0; rep < repeats; ++rep) cells.push_back({at, rep});
  return cells;
}

/// What the searches or races of a plan ask for.
struct Asked {
  std::vector<Cell> next;
  std::size_t ended = 0, all = 0;
  const char* noun = "";
};

Asked AskSearches(const plan::Plan& plan, const results::ResultFile& file) {
  const figures::Model model(file);
  const std::vector<searches::Boundary> boundaries = searches::FindBoundaries(model);
  const auto ended = std::ranges::count_if(
      boundaries, [](const searches::Boundary& of) { return of.bracket.next.empty(); });
  return {CellsOf(searches::NextPoints(*plan.SearchAxis(), boundaries), plan.repeats),
          static_cast<std::size_t>(ended), boundaries.size(), "searches"};
}

Asked AskRaces(const results::ResultFile& file) {
  const std::vector<races::PlacedRace> all = races::RunRaces(file);
  const auto ended =
      std::ranges::count_if(all, [](const races::PlacedRace& of) { return of.race.HasEnded(); });
  return {races::NextCells(all), static_cast<std::size_t>(ended), all.size(), "races"};
}

}  // namespace

void RunEachPointOnce(plan::Plan& plan) {
  plan.repeats = 1;
  std::erase_if(plan.runs, [](const plan::Run& run) { return run.rep > 0; });
  for (plan::Axis& axis : plan.axes) {
    axis.search.reset();
    axis.race.reset();
  }
}

Round FirstChosenRound(const plan::Plan& plan) {
  Round round{plan.repeats, std::set<std::string>(), {}};
  if (!plan.SearchAxis()) {
    plan.ForEachRun([&](const std::string& id, const auto&, std::uint64_t rep) {
      if (rep == 0) round.ids->insert(id);
    });
    return round;
  }
  for (std::string& id : IdsOf(plan, CellsOf(searches::FirstPoints(plan), plan.repeats)))
    round.ids->insert(std::move(id));
  return round;
}

std::optional<Round> ChosenRoundAfter(const plan::Plan& plan, const Round& done,
                                      const fs::path& results, schedule::ShardChoice shard) {
  const results::ResultFile file(results, results::ProofOf::kStructure);
  const Asked asked = plan.SearchAxis() ? AskSearches(plan, file) : AskRaces(file);
  std::vector<std::string> next = IdsOf(plan, asked.next);
  if (shard.count > 1) {
    std::set<std::string_view> own;
    for (const plan::Run* run : schedule::OrderRuns(plan, shard)) own.insert(run->id);
    std::erase_if(next, [&](const std::string& id) { return !own.contains(id); });
  }
  if (next.empty()) return std::nullopt;
  Round round = done;
  std::size_t added = 0;
  for (std::string& id : next) added += round.ids->insert(std::move(id)).second ? 1 : 0;
  if (added == 0)
    throw options::CommandError(
        fmt::format("the {} of '{}' ask for runs that were executed already, and cannot go on; all "
                    "runs are kept: please report this, with the scenario",
                    asked.noun, plan.benchmark));
  round.progress = fmt::format("{} of {} {} have ended; {} run{} next\n", asked.ended, asked.all,
                               asked.noun, added, added == 1 ? "" : "s");
  return round;
}

ScratchResults::ScratchResults(const plan::Plan& plan, const fs::path& folder, const fs::path& out,
                               schedule::ShardChoice shard, const results::Provenance& provenance)
    : path_(out) {
  path_.replace_extension(fmt::format("found-{}-of-{}.h5", shard.index, shard.count));
  journal::Merge(plan, provenance, {folder}, path_);
}

ScratchResults::~ScratchResults() {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

void CheckChoice(const plan::Plan& plan, bool has_until) {
  if (plan.ChoosesRuns() && has_until)
    throw options::CommandError(fmt::format(
        "--until: '{}' has a {}; remove --until", plan.benchmark,
        plan.SearchAxis() ? "search, which runs every repeat of the points that it needs"
                          : "race, which chooses the repeats itself"));
}

}  // namespace cdb::plans
