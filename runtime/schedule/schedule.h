// Executes every run of a plan that the folder of shards does not contain, one worker process each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/process/launcher.h"
#include "runtime/process/stop.h"
#include "runtime/schedule/order.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"

namespace cdb::schedule {

struct ExecuteOptions {
  std::filesystem::path folder;  ///< of the shards; made where it does not exist
  std::size_t jobs = 1;          ///< runs at a time
  ShardChoice shard = {};
  bool fresh = false;     ///< forget what the folder holds
  bool has_plan = false;  ///< the folder has the plan.yaml, which takes long to compare
  /// How often at most a run is measured again because the machine disturbed it
  /// (machine/noise.h). The quietest is kept.
  std::size_t noisy_retries = 0;
  /// A run that is executed although the folder has its shard, which stays until the new one is
  /// written; null: none.
  std::function<bool(const plan::Run&, const std::filesystem::path& shard)> is_repeated = {};
  /// What is known of a run that is kept elsewhere, and neither executed nor counted; nullopt for
  /// others. Null: all are to be in the folder.
  std::function<std::optional<shards::ShardInfo>(const plan::Run&)> find_elsewhere = {};
  /// The plan in its short form, which takes a merge a tenth of the time and memory to read; empty
  /// where there is none.
  std::string short_plan = {};
  store::Provenance provenance = {};
  const process::StopFlag* stop = nullptr;  ///< may be null
};

/// How the runs of the shard that was asked for stand, each counted once, whoever carried it out.
struct Summary {
  std::size_t done = 0, failed = 0, crashed = 0, timed_out = 0;
  std::size_t spoiled = 0;  ///< of those done: their timings are void (measure/verdict.h)
  std::size_t resumed = 0;  ///< of all, found in the folder
  std::size_t left = 0;     ///< not carried out: the user asked to stop
  int signal = 0;           ///< that asked to stop; 0 where none did

  std::size_t ended() const { return done + failed + crashed + timed_out; }
  /// Exit status 3.
  bool HasBadRuns() const { return ended() != done || spoiled > 0; }
  void Count(const store::Outcome& outcome);
  bool operator==(const Summary&) const = default;
};

/// `75 runs: 73 done (12 before), 1 crashed, 1 timed out`.
std::string Describe(const Summary& summary);

/// Hears how the work goes. All calls come from the thread of Execute.
class ProgressListener {
 public:
  virtual ~ProgressListener() = default;
  /// Of a plan that is executed in parts, before Begin; from 0.
  virtual void BeginPart(std::uint64_t /*part*/, std::uint64_t /*parts*/) {}
  /// `to_do` in the order they will start; `resumed` runs are there already.
  virtual void Begin(const plan::Plan&, const std::vector<const plan::Run*>& /*to_do*/,
                     const Summary& /*resumed*/, std::size_t /*jobs*/) {}
  virtual void RunStarted(const plan::Run&) {}
  /// How far the piles of a running run have settled (measure::SettlingText), when that changes;
  /// empty when they are at rest.
  virtual void RunSettles(const plan::Run&, const std::string& /*how_far*/) {}
  /// Its shard is written.
  virtual void RunEnded(const plan::Run&, const store::RunResult&, double /*wall_s*/) {}
  /// All ended, and `runs` are measured once more with components (`walls, solver`) that runs which
  /// they are compared with had to keep. RunStarted and RunEnded follow for each.
  virtual void Repeat(const plan::Plan&, const std::vector<const plan::Run*>& /*runs*/,
                      const std::string& /*components*/) {}
  /// Somebody else has carried it out meanwhile.
  virtual void RunFound(const plan::Run&, const store::Outcome&) {}
  virtual void Warn(const std::string&) {}
  /// About once a second while nothing else happens.
  virtual void Tick() {}
  /// The last call, also where an error ends the work.
  virtual void End() {}
};

/// Carries out the plan. What has a whole shard in the folder is not run again, whatever its
/// status, unless it left out what a run that it is compared with keeps (shared_omissions.h): its
/// times would be of other work. A broken shard is set aside as `<name>.broken`, with a warning,
/// and its run is run again. Every shard is on the disk before the next run starts in its slot. A
/// stop ends the workers and keeps what is finished. With several jobs each slot has a processor of
/// its own where there are enough. Throws ScheduleError (no worker program, cannot start a process,
/// a shard of another plan) and StoreError (disk full, no such folder); finished runs are kept. To
/// be called from a thread that outlives the call: workers die with the thread that started them.
Summary Execute(const plan::Plan& plan, const ExecuteOptions& options, ProgressListener& listener);

/// The same with another way to carry out a run, for tests.
Summary Execute(const plan::Plan& plan, const ExecuteOptions& options, process::Launcher& launcher,
                ProgressListener& listener);

}  // namespace cdb::schedule
