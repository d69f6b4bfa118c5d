// `cdb submit`: submits the plans of a scenario as job arrays to Slurm, each followed by a merge
// job.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "compiler/plan/input_file.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/result_names.h"
#include "runtime/cli/plans/retry.h"
#include "runtime/cli/plans/sized_plan.h"
#include "runtime/cli/plans/sweep_files.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "runtime/sweep/cluster/follow.h"
#include "runtime/sweep/cluster/slurm.h"
#include "runtime/sweep/cluster/submission.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/sweep/schedule/order.h"
#include "runtime/sweep/schedule/parts.h"
#include "runtime/sweep/schedule/progress.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

/// Target duration of a task, s. Dispatching one takes about a second.
constexpr double kTaskSeconds = 60;
/// Several tasks per core, so that a slow one does not delay the end for long.
constexpr std::uint64_t kTasksOfCore = 4;
/// Time per unit of schedule::EstimatedWork, s, with Bullet's `dbvt` and hundreds of objects.
constexpr double kSecondsOfWork = 1e-6;

struct SubmitArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::string out;
  std::uint64_t tasks = 0;  ///< 0: by work and cores
  cluster::JobOptions job;
  std::vector<std::string> retry;  ///< retry runs with these endings
  std::vector<std::string> plugins;
  std::vector<std::string> settings;  ///< NAME=VALUE, over those of the scenario
  bool is_dry = false;
  bool no_follow = false;
  bool quiet = false;
};

/// One plan and its results file.
struct Target {
  plans::SizedPlan sized;
  fs::path out, folder;
  const plan::Plan& plan() const { return sized.plan; }
};

fs::path ThisProgram() {
  std::error_code error;
  fs::path path = fs::read_symlink("/proc/self/exe", error);
  if (error)
    throw options::CommandError(
        fmt::format("cannot find the path of this program (/proc/self/exe): {}", error.message()));
  return path;
}

std::uint64_t MostThreads(const plan::Plan& plan) {
  std::uint64_t threads = 1;
  for (const plan::Run& run : plan.Bounds())
    threads = std::max(threads, run.scene.world.Count("threads"));
  return threads;
}

/// A rough estimate for all runs on a laptop, s.
double EstimatedSeconds(const plan::Plan& plan) {
  double work = 0;
  for (const plan::Run& run : plan.Bounds()) work += schedule::EstimatedWork(run);
  if (plan.whole)
    work *= static_cast<double>(plan.RunCount()) / static_cast<double>(plan.Bounds().size());
  return kSecondsOfWork * work *
         static_cast<double>(searches::ExpectedRuns(plan, plan.RunCount())) /
         static_cast<double>(plan.RunCount());
}

std::uint64_t ChooseTasks(const SubmitArguments& arguments, const plan::Plan& plan) {
  const cluster::Capacity capacity = cluster::FindCapacity(arguments.job.partition);
  const std::uint64_t points =
      plan.whole ? plan.RunCount() : schedule::ListShards(plan, plan.runs.size()).size();
  const std::uint64_t most = std::max<std::uint64_t>(1, std::min(capacity.most_tasks, points));
  if (arguments.tasks > capacity.most_tasks)
    throw options::CommandError(
        fmt::format("--tasks {}: a job array of this cluster can have at most {} tasks "
                    "(MaxArraySize of slurm.conf)",
                    arguments.tasks, capacity.most_tasks));
  if (arguments.tasks > 0) return std::min(arguments.tasks, most);
  auto wanted =
      static_cast<std::uint64_t>(std::clamp(EstimatedSeconds(plan) / kTaskSeconds, 1.0, 1e9));
  if (capacity.cores > 0)
    wanted = std::min(
        wanted, kTasksOfCore * std::max<std::uint64_t>(1, capacity.cores / MostThreads(plan)));
  return std::min(wanted, most);
}

/// The tasks with a run that is not in `kept` (which may be null) and that has not finished, or one
/// of its references has not.
std::vector<std::uint64_t> FindMissing(const Target& target, std::uint64_t tasks,
                                       const plans::KeptRuns* kept, bool is_quiet) {
  const plan::Plan& plan = target.plan();
  schedule::SweepFolder folder(plan, target.folder, schedule::SweepStart::kResume);
  std::vector<std::uint64_t> missing;
  if (plan.whole) {
    if (kept == nullptr) return schedule::FindUnmarkedShards(plan, target.folder, tasks);
    for (std::uint64_t task = 1; task <= tasks; ++task) missing.push_back(task);
    return missing;  // tasks without a missing run end at once
  }
  std::set<std::string_view> missing_runs;
  std::vector<std::string> warnings;
  for (const auto* runs : {&plan.runs, &plan.references})
    for (const plan::Run& run : *runs)
      if (!folder.Find(run, warnings)) missing_runs.insert(run.id);
  if (!is_quiet)
    for (const std::string& warning : warnings) terminal::Say("warning: " + warning + "\n");
  const auto shards = schedule::ListShards(plan, tasks);
  for (std::size_t i = 0; i < shards.size(); ++i)
    if (std::ranges::any_of(shards[i], [&](const plan::Run* run) {
          return (kept == nullptr || !kept->Has(run->id, run->at, run->rep)) &&
                 (missing_runs.contains(run->id) || missing_runs.contains(run->reference) ||
                  missing_runs.contains(run->twin));
        }))
      missing.push_back(i + 1);
  return missing;
}

cluster::Sweep SweepOf(const Target& target, std::uint64_t tasks) {
  const auto path = [](const fs::path& name) { return fs::absolute(name).lexically_normal(); };
  return {target.plan().benchmark,
          {ThisProgram(), fs::current_path(), path(target.folder),
           path(target.folder / "plan.yaml"), path(target.out)},
          tasks,
          MostThreads(target.plan()),
          {}};
}

/// The command that writes the plan for the script of a dry run.
std::string PlanCommand(const SubmitArguments& arguments, const Target& target) {
  const std::string file = terminal::ShellWord(arguments.file);
  const std::string to =
      terminal::ShellWord((fs::absolute(target.folder).lexically_normal() / "plan.yaml").string());
  if (options::IsPlanFile(arguments.file)) return fmt::format("cp {} {}", file, to);
  std::string words = fmt::format("{} plan {} -b {}", terminal::ShellWord(ThisProgram().string()),
                                  file, target.plan().benchmark);
  for (const std::string& plugin : arguments.plugins)
    words += " --plugin " + terminal::ShellWord(plugin);
  for (const std::string& setting : arguments.settings)
    words += " --set " + terminal::ShellWord(setting);
  return words + " -o " + to;
}

/// Refuses a folder that a stopped `cdb run --fresh` has left: it keeps its state there and works
/// on one machine only.
void RefuseOtherWork(const Target& target) {
  if (!journal::FindRequest(target.folder, journal::kFresh).empty())
    throw options::CommandError(
        fmt::format("'{}' has the runs of an interrupted `cdb run --fresh`; finish it by `cdb run` "
                    "first, or remove the folder",
                    target.folder.string()));
}

class Submitter {
 public:
  explicit Submitter(const SubmitArguments& arguments)
      : arguments_(arguments), retry_(arguments.retry), signals_(stop_) {
    std::signal(SIGPIPE, SIG_IGN);
    if (arguments.is_dry && !retry_.is_empty())
      throw options::CommandError("--dry-run prints the script of all runs; remove --retry");
  }

  options::ExitStatus Run() {
    const options::LintText lints =
        arguments_.quiet ? options::LintText::kNone : options::LintText::kOneLine;
    auto plans =
        plans::LoadSizedPlans(arguments_.file, arguments_.benchmark, lints, arguments_.plugins);
    if (plans.empty()) return options::ExitStatus::kScenarioError;
    if (!arguments_.is_dry) cluster::RequireSlurm();
    std::vector<Target> targets;
    for (plans::SizedPlan& sized : plans) {
      fs::path out =
          plans::ResultPath(arguments_.out, sized.plan.benchmark, arguments_.file, plans.size());
      fs::path folder = plans::RunsFolderOf(out);
      targets.push_back({std::move(sized), std::move(out), std::move(folder)});
    }
    options::ExitStatus status = options::ExitStatus::kGood;
    // All plans are submitted before the first is waited for.
    std::vector<std::optional<cluster::Submission>> submitted;
    for (const Target& target : targets) submitted.push_back(Submit(target));
    if (arguments_.is_dry) return status;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      if (arguments_.no_follow && submitted[i]) {
        SayHowToGoOn(targets[i], *submitted[i]);
        continue;
      }
      if (submitted[i]) {
        cluster::Follow(targets[i].plan(), targets[i].folder, *submitted[i], stop_,
                        schedule::StandardError(), arguments_.quiet);
        if (stop_.requested()) {
          for (std::size_t left = i; left < targets.size(); ++left)
            if (submitted[left]) SayHowToGoOn(targets[left], *submitted[left]);
          return options::StoppedBy(stop_.signal());
        }
      }
      status = std::max(status, Finish(targets[i], submitted[i]));
    }
    return status;
  }

 private:
  /// The jobs of the plan: those at work, or new ones. Nullopt if every run has ended, and for a
  /// dry run.
  std::optional<cluster::Submission> Submit(const Target& target) {
    plans::CheckIsOfPlan(target.out.string(), target.plan());
    if (arguments_.is_dry) {
      PrintScript(target);
      return std::nullopt;
    }
    const plans::RetryChoice retry = RetryOf(target);
    std::error_code error;
    if (fs::exists(target.out, error) &&
        plans::CountMissing(results::ResultFile(target.out), target.plan()) == 0)
      plans::JudgeAnew(target.plan(), target.out);
    const bool is_complete = plans::IsThereAlready(target.out, target.plan());
    if (is_complete && retry.is_empty()) {
      Say(fmt::format("'{}' is complete; remove it to run it again\n", target.out.string()));
      return std::nullopt;
    }
    RefuseOtherWork(target);
    const auto before = cluster::ReadSubmission(target.folder);
    if (before && before->plan_sha256 == target.plan().Sha256() && IsAtWork(*before)) {
      if (retry.Words() != plans::FindStartedRetry(target.folder).Words())
        throw options::CommandError(
            fmt::format("job {} is working on '{}'; retry when it has ended", before->array,
                        target.out.string()));
      Say(fmt::format("job {} is working on '{}'; following it\n", before->array,
                      target.out.string()));
      return before;
    }
    if (!retry.is_empty() && plans::FindStartedRetry(target.folder).is_empty()) {
      const std::string why =
          plans::PrepareRetry(target.plan(), target.folder, target.out, retry, is_complete);
      if (!why.empty()) {
        Say(why);
        return std::nullopt;
      }
    }
    return SubmitMissing(target, retry, before);
  }

  /// The runs to run again in the existing result: by --retry, or by an unfinished retry.
  plans::RetryChoice RetryOf(const Target& target) const {
    std::error_code error;
    if (!fs::exists(target.out, error)) {
      if (!retry_.is_empty())
        Say(fmt::format("'{}' does not exist, so there is nothing to retry: executing every run\n",
                        target.out.string()));
      return {};
    }
    return retry_.With(plans::FindStartedRetry(target.folder));
  }

  bool IsAtWork(const cluster::Submission& before) {
    std::string why;
    const auto active = cluster::FindActive(before.array, before.merge, why);
    if (!active)
      throw options::CommandError(
          fmt::format("cannot tell whether job {} is still running: {}; nothing was submitted: try "
                      "again when Slurm answers",
                      before.array, why));
    return active->count() > 0;
  }

  std::optional<cluster::Submission> SubmitMissing(
      const Target& target, const plans::RetryChoice& retry,
      const std::optional<cluster::Submission>& before) {
    const plan::Plan& plan = target.plan();
    const std::uint64_t tasks =
        before && arguments_.tasks == 0 && before->plan_sha256 == plan.Sha256()
            ? before->tasks
            : ChooseTasks(arguments_, plan);
    const plans::FolderLock lock(target.folder);
    const cluster::SubmissionLock submitting(target.folder);
    if (!submitting.is_held())
      throw options::CommandError(
          fmt::format("another cdb is submitting '{}'; nothing was submitted: the same command "
                      "follows its jobs when it has ended",
                      target.out.string()));
    // Submitted by another cdb before this one had the lock.
    const auto meanwhile = cluster::ReadSubmission(target.folder);
    if (meanwhile && meanwhile->plan_sha256 == plan.Sha256() &&
        (!before || before->array != meanwhile->array) && IsAtWork(*meanwhile))
      return meanwhile;
    cluster::Sweep sweep = SweepOf(target, tasks);
    std::optional<plans::KeptRuns> kept;
    if (!retry.is_empty()) {
      kept.emplace(target.out, retry);
      // The tasks read it.
      journal::Ask(target.folder, plan.Sha256(), journal::kRetry, retry.Text());
    }
    sweep.missing = FindMissing(target, tasks, kept ? &*kept : nullptr, arguments_.quiet);
    const bool is_short = !plan.whole && !target.sized.short_text.empty();
    {
      const schedule::SweepFolder folder(plan, target.folder, schedule::SweepStart::kResume);
      folder.WritePlan(plan);
      if (is_short) folder.WriteShortPlan(target.sized.short_text);
    }
    if (is_short) sweep.files.plan.replace_filename(schedule::kShortPlanName);
    if (sweep.missing.empty()) return std::nullopt;
    const std::string array = cluster::Submit(cluster::ArrayJob(sweep, arguments_.job));
    cluster::Submission made = {plan.Sha256(), tasks, array, array};
    try {
      // Recorded before there is a merge job, so that a later `cdb submit` follows the array.
      cluster::WriteSubmission(made, target.folder);
      made.merge = cluster::Submit(cluster::MergeJob(sweep, arguments_.job, array));
      cluster::WriteSubmission(made, target.folder);
    } catch (...) {
      cluster::Cancel(array);
      if (made.merge != array) cluster::Cancel(made.merge);
      throw;
    }
    Say(fmt::format("submitted job {}: {} of {} tasks of {} runs; and job {}, which merges them\n",
                    made.array, sweep.missing.size(), tasks, plan.RunCount(), made.merge));
    return made;
  }

  void PrintScript(const Target& target) {
    const std::uint64_t tasks = ChooseTasks(arguments_, target.plan());
    cluster::Sweep sweep = SweepOf(target, tasks);
    for (std::uint64_t task = 1; task <= tasks; ++task) sweep.missing.push_back(task);
    terminal::PrintExact(
        cluster::DryRunText(sweep, arguments_.job, PlanCommand(arguments_, target)));
  }

  /// Called after the jobs: their merge job may have been lost with a controller.
  options::ExitStatus Finish(const Target& target,
                             const std::optional<cluster::Submission>& submission) {
    const plan::Plan& plan = target.plan();
    plans::FolderLock lock(target.folder);
    const std::size_t not_again = plans::CountNotRunAgain(plan, target.folder, target.out);
    const bool is_retried = !plans::FindStartedRetry(target.folder).is_empty();
    if (!plans::IsThereAlready(target.out, plan) || is_retried) {
      std::error_code error;
      const bool has_result = fs::exists(target.out, error);
      if (!plans::HasRuns(target.folder)) {
        SayMissing(target, submission,
                   has_result ? std::max(not_again,
                                         plans::CountMissing(results::ResultFile(target.out), plan))
                              : plan.RunCount());
        return options::ExitStatus::kEnvironmentError;
      }
      // Runs that the merge job has merged, if it ran, and any that came later.
      plans::MergeOnto(plan, {target.folder}, target.out);
      const std::size_t missing =
          std::max(not_again, plans::CountMissing(results::ResultFile(target.out), plan));
      if (missing > 0) {
        SayMissing(target, submission, missing);
        return std::max(plans::ShowResult(target.out, arguments_.quiet),
                        options::ExitStatus::kEnvironmentError);
      }
    }
    plans::RemoveMergedRuns(plan, target.folder, lock, /*is_quiet=*/true);
    return plans::ShowResult(target.out, arguments_.quiet);
  }

  void SayMissing(const Target& target, const std::optional<cluster::Submission>& submission,
                  std::size_t missing) {
    std::string text =
        fmt::format("{} of {} runs are missing; the same command submits them again\n", missing,
                    target.plan().RunCount());
    if (submission) {
      constexpr std::size_t kMostListed = 5;
      const auto failures = cluster::FindFailures(submission->array);
      std::size_t listed = 0;
      for (const auto& [task, state] : failures) {
        if (listed++ == kMostListed) break;
        const fs::path log = target.folder / cluster::LogName(submission->array, task);
        text += fmt::format("  task {}: {}; {}\n", task, state, LogText(log));
      }
      if (failures.size() > kMostListed)
        text += fmt::format("  and {} more tasks\n", failures.size() - kMostListed);
      if (failures.empty())
        text += fmt::format("  the logs of its tasks are {}\n",
                            (target.folder / "slurm-*.log").string());
    }
    terminal::Say(text);
  }

  /// The last line of the log, or its path if there is none.
  static std::string LogText(const fs::path& log) {
    std::string why, last;
    std::istringstream lines(plan::ReadInputFile(log, why).value_or(""));
    for (std::string line; std::getline(lines, line);)
      if (!line.empty()) last = line;
    return last.empty() ? log.string() : fmt::format("{}: {}", log.string(), last);
  }

  void SayHowToGoOn(const Target& target, const cluster::Submission& submission) {
    Say(
        fmt::format("job {} continues without this command; the same command follows it again, "
                    "`scancel {} {}` ends it; the results will be in '{}'\n",
                    submission.array, submission.array, submission.merge, target.out.string()));
  }

  void Say(const std::string& text) const {
    if (!arguments_.quiet) terminal::Say(text);
  }

  const SubmitArguments& arguments_;
  const plans::RetryChoice retry_;
  process::StopFlag stop_;
  process::StopOnSignals signals_;
};

void DeclareSubmit(options::Subcommand& command) {
  const auto arguments = std::make_shared<SubmitArguments>();
  command.Required("FILE", arguments->file, "scenario file, or a plan as YAML");
  command.Benchmark(arguments->benchmark);
  command.Out(arguments->out,
              "results file, or a folder for them, visible to every node (default: FILE.h5; "
              "BENCHMARK.h5 if FILE has several)");
  command.Count("--tasks", arguments->tasks,
                "number of tasks (default: each has a minute of work or more)");
  command.Flag("--exclusive", arguments->job.is_exclusive, "one task per node, exclusively");
  command.Optional("--partition", arguments->job.partition, "partition of the cluster");
  command.Optional("--time", arguments->job.time, "time limit of a task, in the format of sbatch");
  command.Optional("--account", arguments->job.account, "account to charge");
  command.Repeated("--sbatch", arguments->job.more,
                   "pass an option to sbatch: --sbatch=--mem=2G; repeat the option for several");
  command.Retry(arguments->retry, "file");
  command.Flag("--dry-run", arguments->is_dry,
               "print a shell script that submits the same jobs, and submit nothing");
  command.Flag("--no-follow", arguments->no_follow, "submit, and do not wait for the jobs");
  command.Quiet(arguments->quiet, "print only errors");
  command.Plugins(arguments->plugins);
  command.Set(arguments->settings);
  command.Action([arguments] {
    options::SetInScenario(arguments->file, arguments->benchmark, arguments->settings);
    return Submitter(*arguments).Run();
  });
}

}  // namespace

/// Submits job arrays to a Slurm cluster, each followed by a merge job. Exit status 2 if runs are
/// missing at the end.
options::Command SubmitCommand() {
  return {.name = "submit",
          .help = "run a scenario file or a plan on a Slurm cluster; resume where it stopped",
          .declare = DeclareSubmit};
}

}  // namespace cdb::cli
