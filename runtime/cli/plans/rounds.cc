#include "runtime/cli/plans/rounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/model.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/results/journal/merge.h"

namespace cdb::plans {

namespace fs = std::filesystem;

namespace {

/// The ids of all repeats of these points. `points`: in grid order.
std::vector<std::string> IdsOf(const plan::Plan& plan, const std::vector<figures::Point>& points) {
  std::vector<std::string> ids;
  plan.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t) {
    if (std::ranges::binary_search(points, at)) ids.push_back(id);
  });
  return ids;
}

}  // namespace

Round FirstSearchRound(const plan::Plan& plan) {
  Round round{plan.repeats, std::set<std::string>(), {}};
  for (std::string& id : IdsOf(plan, searches::FirstPoints(plan))) round.ids->insert(std::move(id));
  return round;
}

std::optional<Round> SearchRoundAfter(const plan::Plan& plan, const Round& done,
                                      const fs::path& results, schedule::ShardChoice shard) {
  const results::ResultFile file(results, results::ProofOf::kStructure);
  const figures::Model model(file);
  const std::vector<searches::Boundary> boundaries = searches::FindBoundaries(model);
  std::vector<std::string> next = IdsOf(plan, searches::NextPoints(*plan.SearchAxis(), boundaries));
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
    throw options::CommandError(fmt::format(
        "the search of '{}' asks for runs that were executed already, and cannot go on; all runs "
        "are kept: please report this, with the scenario",
        plan.benchmark));
  const auto ended = std::ranges::count_if(
      boundaries, [](const searches::Boundary& of) { return of.bracket.next.empty(); });
  round.progress = fmt::format("{} of {} searches have ended; {} run{} next\n", ended,
                               boundaries.size(), added, added == 1 ? "" : "s");
  return round;
}

ScratchResults::ScratchResults(const plan::Plan& plan, const fs::path& folder, const fs::path& out,
                               schedule::ShardChoice shard, const results::Provenance& provenance)
    : path_(out) {
  path_.replace_extension(fmt::format("search-{}-of-{}.h5", shard.index, shard.count));
  journal::Merge(plan, provenance, {folder}, path_);
}

ScratchResults::~ScratchResults() {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

void CheckSearch(const plan::Plan& plan, bool has_until) {
  if (plan.SearchAxis() && has_until)
    throw options::CommandError(fmt::format(
        "--until: '{}' has a search, which runs every repeat of the points that it needs; remove "
        "--until",
        plan.benchmark));
}

}  // namespace cdb::plans
