// The order in which the runs of a plan are executed, and their distribution among shards.
#pragma once

#include <cstdint>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::schedule {

/// `--shard K/N`: the K-th of N parts of a plan, from 1.
struct ShardChoice {
  std::uint64_t index = 1;
  std::uint64_t count = 1;
};

/// Throws ScheduleError for a shard that does not exist.
void CheckShard(ShardChoice shard);

/// Each run that `shard` selects, once (a run at two points of the grid has one id). Repeats are
/// outermost, then the points of the grid, then the detectors of a point, shuffled. Runs that
/// differ only in the detector are therefore neighbours, no detector always goes first, and a drift
/// of the machine affects all of them. Such runs are always in the same shard; shards are balanced
/// by estimated work. The order is the same on every machine for the same plan. Throws
/// ScheduleError for a shard that does not exist.
std::vector<const plan::Run*> OrderRuns(const plan::Plan& plan, ShardChoice shard = {});

/// The runs of each shard of `count`, in no particular order; shards beyond the last are empty. At
/// most as many shards have runs as there are points times repeats.
std::vector<std::vector<const plan::Run*>> ListShards(const plan::Plan& plan, std::uint64_t count);

/// The references that `runs` are compared with, each once, in the order of the plan.
std::vector<const plan::Run*> ReferencesOf(const plan::Plan& plan,
                                           const std::vector<const plan::Run*>& runs);

/// Work of a run in arbitrary units, to weigh runs that have not been timed: objects x cycles, plus
/// the cost of a process.
double EstimatedWork(const plan::Run& run);

}  // namespace cdb::schedule
