// Rounds of a sweep whose results decide which runs follow: the repeats of `--until`, the points of
// a search, the repeats of a race.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "compiler/plan/plan.h"
#include "runtime/results/store.h"
#include "runtime/sweep/schedule/order.h"

namespace cdb::plans {

/// The runs of one round, with those of all rounds before it.
struct Round {
  std::uint64_t repeats = 0;                      ///< of each point
  std::optional<std::set<std::string>> ids = {};  ///< of the runs; nullopt: all
  std::string progress = {};                      ///< of a search or a race, a line

  /// A run may be at several points, whose id is the same.
  bool Has(const plan::Run& run) const {
    return run.rep < repeats && (!ids || ids->contains(run.id));
  }
};

/// One run of each point, also of a plan that would choose among them by their results.
void RunEachPointOnce(plan::Plan& plan);

// Of a plan that chooses runs by results: with searches or races.

/// The runs that every search or race of the plan begins with.
Round FirstChosenRound(const plan::Plan& plan);

/// The runs that the searches or races of `shard` need after those of `done`, which are in
/// `results`; nullopt once they have ended. Throws StoreError, and CommandError if they ask for
/// runs that were executed already.
std::optional<Round> ChosenRoundAfter(const plan::Plan& plan, const Round& done,
                                      const std::filesystem::path& results,
                                      schedule::ShardChoice shard);

/// The finished runs of a folder in a results file of its own, which is removed again: a shard of
/// searches or races reads what they have found so far. Throws StoreError.
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

/// Throws CommandError for a plan with searches or races that goes with `--until`.
void CheckChoice(const plan::Plan& plan, bool has_until);

}  // namespace cdb::plans
