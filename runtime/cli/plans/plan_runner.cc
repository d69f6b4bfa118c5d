#include "runtime/cli/plans/plan_runner.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "library/content_cache.h"
#include "runtime/cli/options/provenance.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/earlier_runs.h"
#include "runtime/cli/plans/sweep_files.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/model.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/protocol/machine/event_counters.h"
#include "runtime/protocol/machine/machine.h"
#include "runtime/protocol/series.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/journal/merge.h"
#include "runtime/sweep/cluster/submission.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/sweep/schedule/parts.h"
#include "runtime/sweep/schedule/progress.h"
#include "runtime/terminal/console.h"

namespace cdb::plans {
namespace fs = std::filesystem;

void MakeResultsFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw options::CommandError(fmt::format("cannot make the folder '{}': {}; choose another by -o",
                                            folder.string(), error.message()));
}

/// Only on a terminal, where a user can wait for a quiet machine. The results record the load in
/// any case.
void PlanRunner::WarnOfLoad(const plan::Plan& plan) const {
  const double load = machine::LoadAverage(), processors = machine::OnlineProcessorCount();
  if (options_.is_quiet || isatty(STDERR_FILENO) == 0 || !plan.Records("timing") ||
      !(load > processors))
    return;
  fmt::print(
      stderr,
      "cdb: warning: load {:.1f} on {:.0f} processor{}: other programs disturb the timings\n", load,
      processors, processors == 1 ? "" : "s");
}

/// Names the events that this machine does not count. Runs on other machines may have them.
void PlanRunner::WarnOfCounters(const plan::Plan& plan) const {
  if (options_.is_quiet || !plan.Records("counters")) return;
  const std::string missing = machine::MissingText(machine::EventCounters().missing());
  if (!missing.empty())
    terminal::Say(fmt::format("cdb: warning: this machine does not count {}\n", missing));
}

PlanRunner::PlanRunner(PlanRunnerOptions options)
    : options_(std::move(options)), provenance_(options::CollectProvenance()), signals_(stop_) {
  provenance_["jobs"] = fmt::format("{}", options_.jobs);
  const auto note = [this](const char* fact, const char* option,
                           const std::vector<std::string>& values) {
    std::string text;
    for (const std::string& value : values)
      text += fmt::format(" {} {}", option, terminal::ShellWord(value));
    if (!text.empty()) provenance_[fact] = text.substr(1);
  };
  note("plugins", "--plugin", options_.plugins);
  note("settings", "--set", options_.settings);
  const std::string fault = library::CacheFault(library::CacheFolder());
  if (!fault.empty() && !options_.is_quiet) terminal::Say(fmt::format("cdb: warning: {}\n", fault));
  std::signal(SIGPIPE, SIG_IGN);
}

schedule::Summary PlanRunner::ExecuteRuns(const SizedPlan& plan,
                                          schedule::ExecuteOptions execute) const {
  execute.jobs = options_.jobs;
  execute.shard = options_.shard;
  execute.noisy_retries = options_.noisy_retries;
  execute.provenance = provenance_;
  execute.stop = &stop_;
  schedule::ProgressListener silent;
  schedule::Progress progress(schedule::StandardError());
  schedule::ProgressListener& listener =
      options_.is_quiet ? silent : static_cast<schedule::ProgressListener&>(progress);
  if (plan.grid == nullptr) {
    execute.short_plan = plan.short_text;
    return schedule::Execute(plan.plan, execute, listener);
  }
  const auto list = [&plan](std::uint64_t index, std::uint64_t count) {
    return plan.ListPart(index, count);
  };
  return schedule::ExecuteParts(plan.plan, list, execute, listener);
}

void PlanRunner::SayStopped(const SizedPlan& plan, const ExecutedPlan& end) const {
  terminal::Say(fmt::format("stopped: {} of {} runs are kept in '{}'; the same command resumes\n",
                            end.summary.ended(),
                            plan.grid != nullptr ? plan.plan.RunCount() / options_.shard.count
                                                 : end.summary.ended() + end.summary.left,
                            end.folder.string()));
}

std::optional<std::uint64_t> PlanRunner::RepeatsAfter(const plan::Plan& plan,
                                                      const Precision& reached,
                                                      std::uint64_t done) const {
  // A stopped command had begun these repeats.
  if (reached.missing > 0 && reached.repeats > done) return reached.repeats;
  const std::uint64_t next = NextRepeats(reached, *options_.until, plan.repeats);
  if (!options_.is_quiet)
    terminal::Say(fmt::format("{}{}\n", Describe(reached, *options_.until),
                              next > reached.repeats ? fmt::format("; continuing to {}", next)
                              : next == plan.repeats ? "; `repeats` is reached"
                                                     : ""));
  return next > reached.repeats ? std::optional(next) : std::nullopt;
}

/// Those of a runner that was killed right after the merge.
void PlanRunner::RemoveLeftovers(const plan::Plan& plan, const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  FolderLock leftovers(folder);
  if (leftovers.TryLockAlone()) RemoveMergedRuns(plan, folder);
}

bool PlanRunner::IsComplete(const plan::Plan& plan, const fs::path& out) const {
  if (!IsThereAlready(out, plan)) return false;
  RemoveLeftovers(plan, RunsFolderOf(out));
  if (!options_.is_quiet)
    terminal::Say(fmt::format("'{}' is complete; --fresh runs it again\n", out.string()));
  return true;
}

std::optional<Round> PlanRunner::FirstRound(const plan::Plan& plan, const fs::path& out,
                                            bool has_results) const {
  if (plan.ChoosesRuns()) {
    const Round none{plan.repeats, std::set<std::string>(), {}};
    return has_results ? ChosenRoundAfter(plan, none, out, options_.shard)
                       : std::optional(FirstChosenRound(plan));
  }
  if (!options_.until) return Round{plan.repeats, {}};
  const std::uint64_t least = figures::Bootstrap::kLeastForInterval;
  if (!has_results) return Round{least, {}};
  const Precision reached = PrecisionOf(results::ResultFile(out), *options_.until);
  if (!reached.IsWholeRound() || HasRuns(RunsFolderOf(out)))
    return Round{std::max(least, reached.repeats), {}};
  const auto repeats = RepeatsAfter(plan, reached, reached.repeats);
  return repeats ? std::optional(Round{*repeats, {}}) : std::nullopt;
}

std::optional<Round> PlanRunner::RoundAfter(const plan::Plan& plan, const fs::path& out,
                                            const fs::path& folder, const Round& done) const {
  if (plan.ChoosesRuns()) {
    if (options_.shard.count == 1) return ChosenRoundAfter(plan, done, out, options_.shard);
    const ScratchResults scratch(plan, folder, out, options_.shard, provenance_);
    return ChosenRoundAfter(plan, done, scratch.path(), options_.shard);
  }
  if (!options_.until) return std::nullopt;
  const auto repeats = RepeatsAfter(
      plan, PrecisionOf(results::ResultFile(out, results::ProofOf::kStructure), *options_.until),
      done.repeats);
  return repeats ? std::optional(Round{*repeats, {}}) : std::nullopt;
}

schedule::ExecuteOptions PlanRunner::ExecuteOptionsFor(const plan::Plan& plan,
                                                       const fs::path& folder,
                                                       bool starts_over) const {
  schedule::ExecuteOptions execute;
  execute.folder = folder;
  if (starts_over)
    execute.start = options_.shard.count > 1 ? schedule::SweepStart::kFresh
                                             : schedule::SweepStart::kFreshForResult;
  if (const auto submitted = cluster::ReadSubmission(folder); submitted && !starts_over)
    execute.has_plan = submitted->plan_sha256 == plan.Sha256();
  if (!options_.retry.is_empty())
    execute.is_repeated = [this](const journal::RunInfo& run) { return options_.retry.Wants(run); };
  return execute;
}

ExecutedPlan PlanRunner::Execute(const SizedPlan& sized, const fs::path& out) const {
  const plan::Plan& plan = sized.plan;
  const fs::path folder = RunsFolderOf(out);
  std::error_code error;
  files::RemoveStaleTemporariesBeside(out);
  if (options_.keeps_earlier && !options_.fresh && options_.shard.count == 1 &&
      options_.retry.is_empty()) {
    const auto earlier = KeepEarlierRuns(sized, out, provenance_);
    if (earlier && !options_.is_quiet)
      terminal::Say(Describe(*earlier, plan.benchmark, /*is_planned=*/false) + "\n");
  }
  const RetryChoice retry = options_.retry.With(FindStartedRetry(folder));
  if (!options_.fresh && !retry.is_empty() && fs::exists(out, error)) {
    if (options_.retry.is_empty() && !options_.is_quiet)
      terminal::Say(fmt::format("resuming the interrupted `--retry` in '{}'\n", out.string()));
    ExecutedPlan end = Retry(sized, out, retry);
    // Runs that end otherwise now may move a boundary, or decide a race.
    if (!end.is_merged || !plan.ChoosesRuns() || IsThereAlready(out, plan)) return end;
  }
  const bool is_part = options_.shard.count > 1;
  const bool goes_on_anew = !is_part && IsMadeAnew(plan, folder);
  const bool is_anew = options_.fresh || goes_on_anew;
  if (!is_anew && IsComplete(plan, out)) return {{}, folder, true};
  if (!options_.retry.is_empty() && !options_.is_quiet && !fs::exists(folder, error))
    terminal::Say(fmt::format(
        "'{}' does not exist, so there is nothing to retry: executing every run\n", out.string()));
  const bool has_results = !is_anew && !is_part && fs::exists(out, error);
  std::optional<Round> round = FirstRound(plan, out, has_results);
  if (!round) {
    JudgeAnew(plan, out);
    RemoveLeftovers(plan, folder);
    return {{}, folder, true};
  }
  FolderLock lock(folder);
  WarnOfLoad(plan);
  WarnOfCounters(plan);
  std::optional<KeptRuns> kept;
  if (has_results) kept.emplace(out, RetryChoice());
  schedule::ExecuteOptions execute =
      ExecuteOptionsFor(plan, folder, options_.fresh && !goes_on_anew);
  const bool has_rounds = options_.until.has_value() || plan.ChoosesRuns();
  if (kept || has_rounds)  // without it, finished parts are skipped by their marks
    execute.find_elsewhere = [&](const plan::Run& run) {
      return round->Has(run) ? (kept ? kept->Find(run) : std::nullopt) : journal::RunInfo{};
    };
  ExecutedPlan end = {{}, folder, false};
  while (round) {
    end.summary = ExecuteRuns(sized, execute);
    execute.start = schedule::SweepStart::kResume;
    execute.is_repeated = {};
    if (end.summary.signal != 0) SayStopped(sized, end);
    if (end.summary.signal != 0 || (is_part && !has_rounds)) return end;
    if (!is_part) MergeRound(plan, out, is_anew);
    const auto next = RoundAfter(plan, out, folder, *round);
    if (next && !options_.is_quiet) terminal::Say(next->progress);
    round = next;
  }
  if (is_part) return end;
  RemoveMergedRuns(plan, folder, lock, options_.is_quiet);
  end.is_merged = true;
  return end;
}

void PlanRunner::MergeRound(const plan::Plan& plan, const fs::path& out, bool is_anew) const {
  // Another runner may have been faster with the same plan.
  if (!is_anew && !options_.until && options_.retry.is_empty() && IsThereAlready(out, plan)) return;
  std::error_code error;
  const fs::path folder = RunsFolderOf(out);
  try {
    journal::Merge(plan, provenance_, {folder}, out,
                   !is_anew && fs::exists(out, error) ? out : fs::path(), searches::AnswersToStore);
  } catch (const journal::DamagedRun& damaged) {
    journal::Journal::OpenToWrite(folder, plan.Sha256()).Forget(damaged.run_id());
    throw;
  }
}

ExecutedPlan PlanRunner::Retry(const SizedPlan& sized, const fs::path& out,
                               const RetryChoice& retry) const {
  const plan::Plan& plan = sized.plan;
  const fs::path folder = RunsFolderOf(out);
  const bool is_started = !FindStartedRetry(folder).is_empty();
  JudgeAnew(plan, out);
  if (options_.shard.count > 1 && !is_started)
    throw options::CommandError(
        "--retry cannot be combined with --shard; to retry on a cluster, use `cdb submit --retry`");
  const bool is_complete =  // refuses another plan
      IsThereAlready(out, plan,
                     ". --retry repeats runs of that plan; any changed setting, such as `timeout` "
                     "or `memory`, makes another plan: run it without --retry first");
  if (!is_started) {
    const std::string why = PrepareRetry(plan, folder, out, retry, is_complete);
    if (!why.empty()) {
      if (!options_.is_quiet) terminal::Say(why);
      return {{}, folder, true};
    }
  }
  const KeptRuns kept(out, retry);
  FolderLock lock(folder);
  if (FindStartedRetry(folder).Words() != retry.Words())
    journal::Ask(folder, plan.Sha256(), journal::kRetry, retry.Text());
  WarnOfLoad(plan);
  WarnOfCounters(plan);
  schedule::ExecuteOptions execute;
  execute.folder = folder;
  execute.find_elsewhere = [&kept](const plan::Run& run) { return kept.Find(run); };
  ExecutedPlan end = {ExecuteRuns(sized, std::move(execute)), folder, false};
  if (end.summary.signal != 0) {
    SayStopped(sized, end);
    return end;
  }
  if (options_.shard.count > 1) return end;
  journal::Merge(plan, provenance_, {folder}, out, out, searches::AnswersToStore);
  if (lock.TryLockAlone()) RemoveMergedRuns(plan, folder);
  end.is_merged = true;
  return end;
}

bool Precision::IsWholeRound() const {
  return repeats >= figures::Bootstrap::kLeastForInterval && missing == 0;
}

Precision PrecisionOf(const results::ResultFile& file, double wanted) {
  const figures::Model model(file, {.only_sound = true});
  Precision precision;
  precision.repeats = file.begun_repeats();
  for (const results::ResultFile::Cell& cell : figures::AllCells(file))
    precision.missing +=
        cell.rep < precision.repeats && file.ReadStatus(cell) == results::Status::kMissing;
  for (const figures::MeasuredPoint& point : model.points()) {
    const figures::Estimate& step = model.TimeOf(point, protocol::Phase::kStep);
    const figures::Interval interval = model.times().IntervalOf(step);
    const double half = std::max(interval.high - step.value, step.value - interval.low);
    if (!std::isfinite(half) || !(step.value > 0)) continue;
    ++precision.points;
    precision.within += half <= wanted * step.value;
    precision.widest = std::max(precision.widest, half / step.value);
  }
  return precision;
}

std::uint64_t NextRepeats(const Precision& reached, double wanted, std::uint64_t most) {
  if (reached.IsReached()) return reached.repeats;
  const double ratio = reached.widest / wanted;
  const auto repeats = static_cast<double>(reached.repeats);
  const double needed = std::clamp(std::ceil(repeats * ratio * ratio), repeats + 1, 2 * repeats);
  return std::min(static_cast<std::uint64_t>(needed), std::max(most, reached.repeats));
}

std::string Describe(const Precision& reached, double wanted) {
  const std::string head = fmt::format("{} repeats: ", reached.repeats);
  if (reached.points == 0) return head + "no point has an interval, as runs are missing or void";
  if (reached.IsReached())
    return head + fmt::format("every mean step is known within {:.3g} %", 100 * wanted);
  return head +
         fmt::format("{} of {} mean steps are known within {:.3g} %, the worst within {:.3g} %",
                     reached.within, reached.points, 100 * wanted, 100 * reached.widest);
}

void CheckUntil(const plan::Plan& plan) {
  if (!plan.Records("timing"))
    throw options::CommandError(
        fmt::format("--until: '{}' records no times; add timing to `record`", plan.benchmark));
  if (plan.repeats <= figures::Bootstrap::kLeastForInterval)
    throw options::CommandError(
        fmt::format("--until: '{}' has repeats {}, the upper limit, but an interval needs {}; "
                    "write more, such as repeats 50",
                    plan.benchmark, plan.repeats, figures::Bootstrap::kLeastForInterval));
}

}  // namespace cdb::plans
