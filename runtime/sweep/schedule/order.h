// The order in which the runs of a plan are executed, and their distribution among shards.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
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
/// of the machine affects all of them; the same holds for all configurations of a race. Such runs
/// are always in the same shard, as are those of one search; shards are balanced by estimated work.
/// The order is the same on every machine for the same plan. Throws ScheduleError for a shard that
/// does not exist.
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

// Lower bounds of the memory, disk and time that a plan takes, and the models that it names. A plan
// that exceeds this machine is refused with the numbers before it starts, not after hours of work.

struct Demand {
  double objects = 0;   ///< number in the largest scene
  double recorded = 0;  ///< bytes: the largest recording and its record, which exist at the same
                        ///< time
  double scene = 0;     ///< bytes: bodies of the largest scene
  double disk = 0;      ///< bytes: the journal and the merged file, at the best compression
  double time = 0;      ///< s: all runs, at a rate that no engine exceeds
};

/// A lower bound for executing `runs`, `jobs` at a time.
Demand LeastDemand(const std::vector<const plan::Run*>& runs, std::uint64_t jobs);
/// The same for one of `parts` equal parts of the plan.
Demand LeastDemand(const plan::Plan& plan, std::uint64_t jobs = 1, std::uint64_t parts = 1);

struct Capacity {
  double memory = std::numeric_limits<double>::infinity();  ///< bytes
  double disk = std::numeric_limits<double>::infinity();    ///< bytes
};

/// All memory of this machine, or of the control group; the disk is not checked.
Capacity WholeMachine();
/// Free memory, and free space on the disk of `folder` or of the nearest existing folder above it.
Capacity FreeNow(const std::filesystem::path& folder);

/// The reason why it does not fit, with the numbers and the remedy; empty if it may fit.
std::string WhyTooLarge(const Demand& demand, const Capacity& capacity);

/// Throws ScheduleError with WhyTooLarge for the capacity that is free now.
void CheckFits(const std::string& benchmark, const Demand& demand,
               const std::filesystem::path& folder);

/// Throws ScheduleError for a model that one of the runs names and this machine lacks.
void CheckModels(const std::string& benchmark, const std::vector<const plan::Run*>& runs);

}  // namespace cdb::schedule
