// What a plan takes at least of memory, disk and time, and the models that it names. Where this
// machine has less, it is refused with the numbers before hours of work rather than after.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::schedule {

struct Demand {
  double objects = 0;   ///< of the largest scene
  double recorded = 0;  ///< bytes: the recording of the widest run and its shard, side by side
  double scene = 0;     ///< bytes: bodies of the largest scene
  double disk = 0;      ///< bytes: all shards and the merged file, as small as they may get
  double time = 0;      ///< s: all runs, each at the rate of an engine that has nothing to do
};

/// A lower bound of executing `runs`, `jobs` at a time.
Demand LeastDemand(const std::vector<const plan::Run*>& runs, std::uint64_t jobs);
/// The same of the `parts`-th part of the plan.
Demand LeastDemand(const plan::Plan& plan, std::uint64_t jobs = 1, std::uint64_t parts = 1);

struct Capacity {
  double memory = std::numeric_limits<double>::infinity();  ///< bytes
  double disk = std::numeric_limits<double>::infinity();    ///< bytes
};

/// All memory of this machine, or of the control group; the disk is not looked at.
Capacity WholeMachine();
/// What is free now, and free on the disk of `folder` or of the nearest folder above it.
Capacity FreeNow(const std::filesystem::path& folder);

/// Why it does not fit, with the numbers and the remedy; empty where it may.
std::string WhyTooLarge(const Demand& demand, const Capacity& capacity);

/// Throws ScheduleError with WhyTooLarge of what is free now.
void CheckFits(const std::string& benchmark, const Demand& demand,
               const std::filesystem::path& folder);

/// Throws ScheduleError for a model that one of the runs names and this machine lacks.
void CheckModels(const std::string& benchmark, const std::vector<const plan::Run*>& runs);

}  // namespace cdb::schedule
