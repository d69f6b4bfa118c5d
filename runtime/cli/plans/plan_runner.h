// Executes a plan into its results file: runs what is missing, merges and removes the journals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/retry.h"
#include "runtime/cli/plans/rounds.h"
#include "runtime/cli/plans/sized_plan.h"
#include "runtime/results/store.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/sweep/schedule/schedule.h"

namespace cdb::plans {

// `cdb run --until P%`: repeats in rounds, until the 95 % interval of every mean step is within P
// %.
//
// After a round every point has the same number of repeats, so that detectors stay comparable and
// intervals paired. An interval shrinks with the square root of the repeats: the widest one decides
// the size of the next round, which at most doubles them. Stopping when intervals are narrow makes
// them a little too narrow, by less the more repeats there are (Anscombe 1952, Large-sample theory
// of sequential estimation).

/// The precision of the mean steps of a results file.
struct Precision {
  std::uint64_t repeats = 0;  ///< of each point
  std::size_t missing = 0;    ///< number of runs in them that nobody has started
  std::size_t points = 0;     ///< number with an interval: all repeats are there and sound
  std::size_t within = 0;     ///< number of these whose interval is within the wanted fraction of
                              ///< the mean
  double widest = 0;  ///< largest distance from a mean to an end of its interval, as a fraction
  bool IsReached() const { return within == points; }
  /// True if there are enough repeats for intervals, and none is missing.
  bool IsWholeRound() const;
};

/// `wanted`: a fraction of the mean, above 0. Throws StoreError.
Precision PrecisionOf(const results::ResultFile& file, double wanted);

/// The repeats of the next round, at most `most`; the present number, of whole rounds, if no more
/// are needed.
std::uint64_t NextRepeats(const Precision& reached, double wanted, std::uint64_t most);

/// `5 repeats: 11 of 12 mean steps are known within 1 %, the worst within 1.8 %`.
std::string Describe(const Precision& reached, double wanted);

/// Throws CommandError for a plan without times, or with too few repeats to end them early.
void CheckUntil(const plan::Plan& plan);

struct PlanRunnerOptions {
  std::size_t jobs = 1;
  bool fresh = false;                     ///< start over
  bool is_quiet = false;                  ///< no progress
  bool keeps_earlier = false;             ///< runs of an earlier plan (earlier_runs.h); without it,
                                          ///< results of another plan are refused
  schedule::ShardChoice shard = {};       ///< the part of each plan that is run
  std::vector<std::string> plugins = {};  ///< libraries in addition to those that the scenario file
                                          ///< names
  RetryChoice retry = {};                 ///< finished runs to run again
  std::size_t noisy_retries = 0;          ///< schedule::ExecuteOptions
  /// Stop repeating once every interval is within this fraction of its mean step.
  std::optional<double> until = {};
  std::vector<std::string> settings = {};  ///< NAME=VALUE of the command line
};

struct ExecutedPlan {
  schedule::Summary summary;  ///< empty if every run was already in the results
  std::filesystem::path folder;
  /// `out` holds all of the plan. False if only a shard of it was requested.
  bool is_merged = false;
};

/// For commands that write several results files. Throws CommandError.
void MakeResultsFolder(const std::filesystem::path& folder);

/// Executes the plans of one command. While it lives, signals request a stop, and writing to a
/// closed pipe does not end the program. Provenance is collected once. Not thread-safe, and only
/// one may exist in a process at a time.
class PlanRunner {
 public:
  explicit PlanRunner(PlanRunnerOptions options);

  /// `out`: the results file; its journals lie beside it. Continues where an earlier call stopped.
  /// If stopped by a signal, prints a message and keeps the finished runs. Throws CommandError,
  /// StoreError; finished runs are kept then too.
  ExecutedPlan Execute(const SizedPlan& plan, const std::filesystem::path& out) const;
  ExecutedPlan Execute(const plan::Plan& plan, const std::filesystem::path& out) const {
    return Execute(SizedPlan{plan, nullptr}, out);
  }

  bool is_stopped() const { return stop_.requested(); }
  options::ExitStatus StoppedStatus() const { return options::StoppedBy(stop_.signal()); }

 private:
  /// Replaces the runs of a results file that `retry` selects, and adds those that it lacks.
  ExecutedPlan Retry(const SizedPlan& plan, const std::filesystem::path& out,
                     const RetryChoice& retry) const;
  static void RemoveLeftovers(const plan::Plan& plan, const std::filesystem::path& folder);
  /// `out` holds every run of the plan; leftover journals are removed.
  bool IsComplete(const plan::Plan& plan, const std::filesystem::path& out) const;
  /// The first round; nullopt if the results in `out` need none.
  std::optional<Round> FirstRound(const plan::Plan& plan, const std::filesystem::path& out,
                                  bool has_results) const;
  /// The round after `done`, whose runs are in `out`, or, of a shard, in the journals of `folder`;
  /// nullopt after the last.
  std::optional<Round> RoundAfter(const plan::Plan& plan, const std::filesystem::path& out,
                                  const std::filesystem::path& folder, const Round& done) const;
  /// Reports the precision of the results after a round of `done` repeats. Returns the repeats of
  /// the next round; nullopt after the last.
  std::optional<std::uint64_t> RepeatsAfter(const plan::Plan& plan, const Precision& reached,
                                            std::uint64_t done) const;
  schedule::ExecuteOptions ExecuteOptionsFor(const plan::Plan& plan,
                                             const std::filesystem::path& folder,
                                             bool starts_over) const;
  void MergeRound(const plan::Plan& plan, const std::filesystem::path& out, bool is_anew) const;
  schedule::Summary ExecuteRuns(const SizedPlan& plan, schedule::ExecuteOptions execute) const;
  void SayStopped(const SizedPlan& plan, const ExecutedPlan& end) const;
  void WarnOfLoad(const plan::Plan& plan) const;
  void WarnOfCounters(const plan::Plan& plan) const;

  PlanRunnerOptions options_;
  results::Provenance provenance_;
  process::StopFlag stop_;
  process::StopOnSignals signals_;
};

}  // namespace cdb::plans
