// Rounds of a sweep whose results decide which runs follow: the repeats of `--until`, the points of
// a search.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/store.h"
#include "runtime/sweep/schedule/order.h"

namespace cdb::plans {

/// The runs of one round, with those of all rounds before it.
struct Round {
  std::uint64_t repeats = 0;                                      ///< of each point
  std::optional<std::set<std::vector<std::size_t>>> points = {};  ///< nullopt: all
  std::string progress = {};                                      ///< of a search, a line

  bool Has(const plan::Run& run) const {
    return run.rep < repeats && (!points || points->contains(run.at));
  }
};

/// The points that every search of the plan begins with.
Round FirstSearchRound(const plan::Plan& plan);

/// The points that the searches of `shard` need after those of `done`, whose runs are in `results`;
/// nullopt once they have ended. Throws StoreError.
std::optional<Round> SearchRoundAfter(const plan::Plan& plan, const Round& done,
                                      const std::filesystem::path& results,
                                      schedule::ShardChoice shard);

/// The finished runs of a folder in a results file of its own, which is removed again: a shard of a
/// search reads what it has found so far. Throws StoreError.
class ScratchResults {
 public:
  ScratchResults(const plan::Plan& plan, const std::filesystem::path& folder,
                 const std::filesystem::path& out, schedule::ShardChoice shard,
                 const results::Provenance& provenance);
  ScratchResults(const ScratchResults&) = delete;
  ScratchResults& operator=(const ScratchResults&) = delete;
  ~ScratchResults();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Throws CommandError for a plan whose search is too long, so that its runs are not listed, or
/// goes with `--until`.
void CheckSearch(const plan::Plan& plan, bool is_listed, bool has_until);

}  // namespace cdb::plans
