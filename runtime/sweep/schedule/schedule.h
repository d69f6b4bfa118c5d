// Executes every run of a plan that has not finished yet, in one worker process each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "runtime/sweep/process/launcher.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/sweep/schedule/order.h"

namespace cdb::schedule {

struct ExecuteOptions {
  std::filesystem::path folder;  ///< of the sweep; created if it does not exist
  std::size_t jobs = 1;          ///< runs at a time
  ShardChoice shard = {};
  SweepStart start = SweepStart::kResume;
  bool has_plan = false;  ///< the folder already has the plan.yaml, which takes long to compare
  /// The most times that a run is measured again because the machine disturbed it
  /// (machine/noise.h). The quietest measurement is kept.
  std::size_t noisy_retries = 0;
  /// True for a run that is executed although it has finished; its record stays until the new one
  /// is written. Null: for no run.
  std::function<bool(const journal::RunInfo&)> is_repeated = {};
  /// Facts about a run that is kept elsewhere, and is neither executed nor counted; nullopt for
  /// others. Null: all runs belong in the folder.
  std::function<std::optional<journal::RunInfo>(const plan::Run&)> find_elsewhere = {};
  /// The plan in its short form, which a merge reads in a tenth of the time and memory; empty if
  /// there is none.
  std::string short_plan = {};
  results::Provenance provenance = {};
  const process::StopFlag* stop = nullptr;  ///< may be null
};

/// The states of the runs of the selected shard, each counted once, by whichever runner executed
/// it.
struct Summary {
  std::size_t done = 0, failed = 0, crashed = 0, timed_out = 0;
  std::size_t spoiled = 0;  ///< number of done runs with void timings (protocol/verdict.h)
  std::size_t resumed = 0;  ///< number of all runs that were found in the folder
  std::size_t left = 0;     ///< number of runs not executed, because the user requested a stop
  int signal = 0;           ///< signal that requested the stop; 0 if there was none

  std::size_t ended() const { return done + failed + crashed + timed_out; }
  /// True for exit status 3.
  bool HasBadRuns() const { return ended() != done || spoiled > 0; }
  void Count(const results::Outcome& outcome);
  bool operator==(const Summary&) const = default;
};

/// `75 runs: 73 done (12 before), 1 crashed, 1 timed out`.
std::string Describe(const Summary& summary);

/// Receives the progress of the work. All calls come from the thread of Execute.
class ProgressListener {
 public:
  virtual ~ProgressListener() = default;
  /// Called for a plan that is executed in parts, before Begin; counts from 0.
  virtual void BeginPart(std::uint64_t /*part*/, std::uint64_t /*parts*/) {}
  /// `to_do` is in the order of execution; `resumed` runs have finished before.
  virtual void Begin(const plan::Plan&, const std::vector<const plan::Run*>& /*to_do*/,
                     const Summary& /*resumed*/, std::size_t /*jobs*/) {}
  virtual void RunStarted(const plan::Run&) {}
  /// Called when the progress of the piles of a running run (protocol::SettlingText) changes; empty
  /// when they are at rest.
  virtual void RunSettles(const plan::Run&, const std::string& /*how_far*/) {}
  /// Called when a run is in the journal.
  virtual void RunEnded(const plan::Run&, const results::RunResult&, double /*wall_s*/) {}
  /// Called when all runs have ended and `runs` are measured again with components (`walls,
  /// solver`) that runs compared with them had to keep. RunStarted and RunEnded follow for each.
  virtual void Repeat(const plan::Plan&, const std::vector<const plan::Run*>& /*runs*/,
                      const std::string& /*components*/) {}
  /// Called for a run that another runner has executed meanwhile.
  virtual void RunFound(const plan::Run&, const results::Outcome&) {}
  virtual void Warn(const std::string&) {}
  /// Called about once a second while nothing else happens.
  virtual void Tick() {}
  /// The last call, also if an error ends the work.
  virtual void End() {}
};

/// Executes the plan. A run with an intact record in a journal of the folder is not run again,
/// whatever its status, unless it omitted a component that a run compared with it keeps
/// (SharedOmissions), because its times would then be of different work. Runs whose record is
/// damaged are run again, with a warning. Every run is on the disk before the next one starts in
/// its slot. A stop ends the workers and keeps finished runs. With several jobs, each slot has a
/// separate processor if there are enough. Throws ScheduleError (no worker program, cannot start a
/// process, a folder of another plan) and StoreError (disk full, no such folder); finished runs are
/// kept. Must be called from a thread that outlives the call: workers die with the thread that
/// started them.
Summary Execute(const plan::Plan& plan, const ExecuteOptions& options, ProgressListener& listener);

/// The same with another launcher, for tests.
Summary Execute(const plan::Plan& plan, const ExecuteOptions& options, process::Launcher& launcher,
                ProgressListener& listener);

// Makes runs that are compared with one another omit the same components.

/// The visible components (schema::ComponentInfo) decided by `omit auto` that the runs of a plan
/// omitted or kept. Runs that differ only in detector, narrow phase, pair order, threads, seed or
/// repeat are compared: a component that one of them keeps, all must keep, or their times are of
/// different work. Not thread-safe.
class SharedOmissions {
 public:
  /// Records a run that succeeded. `omitted` and `decisions` as in results::RunResult.
  void Note(const plan::Run& run, std::string_view omitted, std::string_view decisions);

  /// Removes the record of a run. Components that it kept are still kept by others.
  void Forget(const plan::Run& run) { omitted_.erase(run.id); }

  /// The names of the components that the run has to keep because a run compared with it keeps
  /// them, separated by spaces; empty if its own decision stands.
  std::string KeptFor(const plan::Run& run) const;

  /// The names of the components that the run was recorded without and has to keep; empty if its
  /// times are valid.
  std::string MissingIn(const plan::Run& run) const;

 private:
  using Components = std::uint32_t;  ///< one bit each

  Components KeptInGroupOf(const plan::Run& run) const;

  std::unordered_map<std::string, Components> kept_;     ///< by group of runs
  std::unordered_map<std::string, Components> omitted_;  ///< by the run's id
};

}  // namespace cdb::schedule
