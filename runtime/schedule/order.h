// The order in which the runs of a plan are carried out, and who carries out which.
#pragma once

#include <cstdint>
#include <vector>

#include "compiler/plan.h"

namespace cdb::runtime {

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
std::vector<const compiler::Run*> OrderRuns(const compiler::Plan& plan, ShardChoice shard = {});

/// The references that `runs` are held against, each once, in the order of the plan.
std::vector<const compiler::Run*> ReferencesOf(const compiler::Plan& plan,
                                               const std::vector<const compiler::Run*>& runs);

/// Work of a run in arbitrary units, to weigh runs that nobody has timed yet: objects x cycles, and
/// the cost of a process.
double EstimatedWork(const compiler::Run& run);

}  // namespace cdb::runtime
