#include "runtime/cli/plans/rounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/model.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/results/journal/merge.h"

namespace cdb::plans {

namespace fs = std::filesystem;

Round FirstSearchRound(const plan::Plan& plan) {
  Round round{plan.repeats, std::set<figures::Point>(), {}};
  for (figures::Point& at : searches::FirstPoints(plan)) round.points->insert(std::move(at));
  return round;
}

std::optional<Round> SearchRoundAfter(const plan::Plan& plan, const Round& done,
                                      const fs::path& results, schedule::ShardChoice shard) {
  const results::ResultFile file(results, results::ProofOf::kStructure);
  const figures::Model model(file);
  std::vector<searches::Boundary> boundaries = searches::FindBoundaries(model);
  if (shard.count > 1) {
    std::set<figures::Point> own;
    for (const plan::Run* run : schedule::OrderRuns(plan, shard))
      own.insert(figures::Without(run->at, *plan.SearchAxis()));
    std::erase_if(boundaries,
                  [&](const searches::Boundary& of) { return !own.contains(of.line.place); });
  }
  Round round = done;
  std::size_t added = 0;
  for (figures::Point& at : searches::NextPoints(*plan.SearchAxis(), boundaries))
    added += round.points->insert(std::move(at)).second ? 1 : 0;
  if (added == 0) return std::nullopt;
  const auto ended = std::ranges::count_if(
      boundaries, [](const searches::Boundary& of) { return of.bracket.next.empty(); });
  round.progress = fmt::format("{} of {} searches have ended; {} point{} next\n", ended,
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

void CheckSearch(const plan::Plan& plan, bool is_listed, bool has_until) {
  if (!plan.SearchAxis()) return;
  if (!is_listed)
    throw options::CommandError(fmt::format(
        "'{}' is searched among {} runs, which are too many to be listed: raise the tolerance of "
        "find(), or split the benchmark",
        plan.benchmark, plan.RunCount()));
  if (has_until)
    throw options::CommandError(fmt::format(
        "--until: '{}' has a search, which runs every repeat of the points that it needs; remove "
        "--until",
        plan.benchmark));
}

}  // namespace cdb::plans
