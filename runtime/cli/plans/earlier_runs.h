// `cdb run` after an edit of the scenario: the finished runs that are still part of its plan are
// kept, and the earlier results are set aside.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "runtime/cli/plans/sized_plan.h"
#include "runtime/results/store.h"

namespace cdb::plans {

struct EarlierRuns {
  std::uint64_t runs = 0;    ///< of the plan
  bool is_searched = false;  ///< only some of them will be run
  std::uint64_t kept = 0;    ///< of these, finished before
  /// Finished runs of the plan that another cdb, Bullet or machine made; they are run again.
  std::uint64_t others = 0;
  std::string unlike;           ///< in what the others differ: `commit, host`
  std::string changes;          ///< plan_changes.h
  std::filesystem::path aside;  ///< the name of the earlier results from now on; may be empty
};

/// `x: objects.quantity 100 -> 200; 12 of 20 runs are kept, 8 are new; the earlier results are now
/// 'x.1.h5'`. `is_planned`: nothing has been done yet.
std::string Describe(const EarlierRuns& earlier, const std::string& benchmark, bool is_planned);

/// What KeepEarlierRuns would keep and rename; changes nothing. `provenance`: of this process.
/// Nullopt if neither `out` nor the folder of its sweep holds runs of another plan. `visit_kept` is
/// called with the id of each run that would be kept.
std::optional<EarlierRuns> FindEarlierRuns(
    const SizedPlan& plan, const std::filesystem::path& out, const results::Provenance& provenance,
    const std::function<void(const std::string& id)>& visit_kept);

/// Prepares `out` and the folder of its sweep for the plan if they hold runs of another plan:
/// merges an unfinished sweep into results, copies the runs that the new plan has, and that this
/// cdb, Bullet and machine made, into the journal of the new sweep, and renames the results. May be
/// interrupted at any moment, and is then completed by the next call; no finished run is lost.
/// Throws CommandError if another cdb is at work in the folder, or has submitted jobs; StoreError.
std::optional<EarlierRuns> KeepEarlierRuns(const SizedPlan& plan, const std::filesystem::path& out,
                                           const results::Provenance& provenance);

}  // namespace cdb::plans
