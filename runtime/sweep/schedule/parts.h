// Executes a plan that is too long to be listed, part by part.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/sweep/process/launcher.h"
#include "runtime/sweep/schedule/schedule.h"

namespace cdb::schedule {

/// The plan with the runs of part `index`, from 0, of `count` (compiler/grid/part.h).
using ListPart = std::function<plan::Plan(std::uint64_t index, std::uint64_t count)>;

/// The largest mean number of runs per part.
inline constexpr std::uint64_t kPartRuns = 10'000;

/// The shards, from 1, of `shards` of `plan` with a part that has not ended, according to the marks
/// in `folder`; all shards if its journals hold fewer runs than the marks say. Throws StoreError.
std::vector<std::uint64_t> FindUnmarkedShards(const plan::Plan& plan,
                                              const std::filesystem::path& folder,
                                              std::uint64_t shards,
                                              std::uint64_t part_runs = kPartRuns);

/// Executes `options.shard` of `plan`, which has a `whole` and lists no runs, as Execute does. Only
/// one part is listed at a time. A part that has ended is marked in the journal, and a later call
/// does not list it again. If the journals hold fewer runs than the marks say, the marks are
/// discarded and every run is looked for. Components that runs of one part had to keep are not
/// known to runs of others (SharedOmissions).
Summary ExecuteParts(const plan::Plan& plan, const ListPart& list, const ExecuteOptions& options,
                     process::Launcher& launcher, ProgressListener& listener,
                     std::uint64_t part_runs = kPartRuns);

/// Uses worker processes.
Summary ExecuteParts(const plan::Plan& plan, const ListPart& list, const ExecuteOptions& options,
                     ProgressListener& listener);

}  // namespace cdb::schedule
