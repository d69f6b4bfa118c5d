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

/// Each run that `shard` picks, once (a run that stands at two points of the grid has one id):
/// repeats outermost, then the points of the grid, then the rivals of a point (runs that differ in
/// nothing but the detector), shuffled. So rivals stand side by side, none always goes first, and a
/// machine that drifts does so for all. Rivals are never in different shards; shards are made even
/// by estimated work. The same on every machine for the same plan. Throws ScheduleError for a shard
/// that there is not.
std::vector<const plan::Run*> OrderRuns(const plan::Plan& plan, ShardChoice shard = {});

/// The references that `runs` are held against, each once, in the order of the plan.
std::vector<const plan::Run*> ReferencesOf(const plan::Plan& plan,
                                           const std::vector<const plan::Run*>& runs);

/// Work of a run in arbitrary units, to weigh runs that nobody has timed yet: objects x cycles, and
/// the cost of a process.
double EstimatedWork(const plan::Run& run);

}  // namespace cdb::schedule
