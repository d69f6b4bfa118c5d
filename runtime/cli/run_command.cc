// `cdb run`: executes the plans of a scenario and writes results files.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "compiler/analysis/reference.h"
#include "compiler/plan/clock.h"
#include "compiler/yaml/plan_yaml.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/provenance.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/earlier_runs.h"
#include "runtime/cli/plans/plan_runner.h"
#include "runtime/cli/plans/result_names.h"
#include "runtime/cli/plans/sized_plan.h"
#include "runtime/cli/plans/sweep_files.h"
#include "runtime/figures/points.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/protocol/verdict.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::string out;  ///< empty: `<benchmark>.h5` in the current folder
  std::uint64_t jobs = 1;
  bool shares_timings = false;  ///< several jobs although times are recorded
  std::uint64_t noisy_retries = 0;
  std::string until;                  ///< a percentage, or empty
  std::string shard;                  ///< `K/N`, or empty
  std::string only;                   ///< the id of one run, or empty
  std::vector<std::string> retry;     ///< retry runs with these endings
  std::string require;                ///< the worst verdict that is good enough, or empty
  std::vector<std::string> plugins;   ///< shared libraries with detectors
  std::vector<std::string> settings;  ///< NAME=VALUE, over those of the scenario
  bool fresh = false;
  bool is_dry = false;  ///< only print what would be run
  bool quiet = false;
};

schedule::ShardChoice ParseShard(const std::string& text) {
  if (text.empty()) return {};
  schedule::ShardChoice choice;
  const char* end = text.data() + text.size();
  const auto [slash, first] = std::from_chars(text.data(), end, choice.index);
  if (first == std::errc{} && slash != end && *slash == '/') {
    const auto [stop, second] = std::from_chars(slash + 1, end, choice.count);
    if (second == std::errc{} && stop == end && choice.index >= 1 && choice.index <= choice.count)
      return choice;
  }
  throw options::CommandError(
      fmt::format("--shard {} is not K/N: the K-th of N parts, from 1/N to N/N", text));
}

/// A plan with just this run, named after it.
plan::Plan PlanOfOne(const plan::Plan& head, plan::Run run) {
  plan::Plan one = head;
  one.title = fmt::format("{}: {}", head.benchmark, plan::Describe(head, run));
  one.repeats = 1;
  one.skipped.clear();
  for (std::size_t i = 0; i < one.axes.size(); ++i)
    one.axes[i].values = {head.axes[i].values[run.at[i]]};
  run.at.assign(one.axes.size(), 0);
  run.rep = 0;
  run.id = plan::RunId(run.scene, run.rep);
  one.runs = {std::move(run)};
  analysis::AddReferences(one);
  return one;
}

std::optional<plan::Plan> FindRun(const grid::Grid& grid, const std::string& id) {
  yaml::RunText text("");
  std::optional<plan::Plan> found;
  grid::ForEachPoint(grid, [&](const grid::Cursor& cursor, const grid::Point& place) {
    const plan::Scene scene = cursor.MakeScene();
    text.Set(scene);
    for (std::uint64_t rep = 0; rep < grid.head.repeats && !found; ++rep)
      if (text.Id(rep) == id) found = PlanOfOne(grid.head, {id, place, rep, scene, {}, {}});
    return !found;
  });
  return found;
}

/// The run `id` as a plan with no other runs. Runs are not listed for it.
std::vector<plans::SizedPlan> OnlyRun(const RunArguments& arguments) {
  const options::LintText lints =
      arguments.quiet ? options::LintText::kNone : options::LintText::kOneLine;
  if (options::IsPlanFile(arguments.file)) {
    for (const plans::SizedPlan& sized :
         plans::LoadSizedPlans(arguments.file, arguments.benchmark, lints, arguments.plugins)) {
      if (sized.grid != nullptr) {
        if (auto one = FindRun(*sized.grid, arguments.only)) return {{*std::move(one), nullptr}};
        continue;
      }
      const auto run = std::ranges::find(sized.plan.runs, arguments.only, &plan::Run::id);
      if (run != sized.plan.runs.end()) return {{PlanOfOne(sized.plan, *run), nullptr}};
    }
  } else {
    const auto grids =
        options::LoadGrids(arguments.file, arguments.benchmark, lints, arguments.plugins);
    if (grids.empty()) return {};
    for (const grid::Grid& grid : grids)
      if (auto one = FindRun(grid, arguments.only)) return {{*std::move(one), nullptr}};
  }
  throw options::CommandError(
      fmt::format("no run has the id '{}'; `cdb plan` lists the ids", arguments.only));
}

/// The plan of the existing results file `-o`, if it contains the run of `--only`; that run is then
/// run again in that file. Empty if there is no such file or it belongs to another plan.
std::vector<plans::SizedPlan> PlanOfExisting(const RunArguments& arguments) {
  std::error_code error;
  if (arguments.only.empty() || arguments.out.empty() || arguments.fresh ||
      !fs::is_regular_file(arguments.out, error))
    return {};
  const std::string there = results::ResultFile(arguments.out).plan_sha256();
  for (plans::SizedPlan& sized : plans::LoadSizedPlans(
           arguments.file, arguments.benchmark, options::LintText::kNone, arguments.plugins)) {
    bool has_run = false;
    sized.plan.ForEachRun([&](const std::string& id, const auto&, std::uint64_t) {
      has_run = has_run || id == arguments.only;
    });
    if (has_run && sized.plan.Sha256() == there) return {std::move(sized)};
  }
  return {};
}

options::ExitStatus RunPlan(const plans::SizedPlan& plan, const fs::path& out,
                            const plans::PlanRunner& runner, bool is_quiet) {
  const plans::ExecutedPlan end = runner.Execute(plan, out);
  if (end.summary.signal != 0) return runner.StoppedStatus();
  if (end.is_merged) return plans::ShowResult(out, is_quiet);
  if (!is_quiet)
    terminal::Print(fmt::format("{}: {}\nwhen every shard is done: cdb merge -o {} {}\n",
                                plan.plan.benchmark, schedule::Describe(end.summary), out.string(),
                                end.folder.string()));
  // Past a boundary, runs may end badly.
  const bool is_bad = end.summary.HasBadRuns() && !plan.plan.SearchAxis();
  return is_bad ? options::ExitStatus::kFailedRuns : options::ExitStatus::kGood;
}

/// The ids of the runs that are finished and would be kept.
std::set<std::string> FindKept(const plans::SizedPlan& sized, const fs::path& out,
                               const RunArguments& arguments, const plans::RetryChoice& retry) {
  const plan::Plan& plan = sized.plan;
  const fs::path folder = plans::RunsFolderOf(out);
  std::set<std::string> kept;
  if (arguments.fresh) return kept;
  const auto earlier = plans::FindEarlierRuns(sized, out, options::CollectProvenance(),
                                              [&kept](const std::string& id) { kept.insert(id); });
  if (earlier) {
    terminal::Print(Describe(*earlier, plan.benchmark, /*is_planned=*/true) + "\n");
    return kept;
  }
  const journal::Journals journals({folder});
  std::optional<plans::KeptRuns> there;
  if (fs::exists(out) && !plans::IsMadeAnew(plan, folder)) there.emplace(out, retry);
  plan.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
    if (journals.Has(id) || (there && there->Has(id, at, rep))) kept.insert(id);
  });
  return kept;
}

/// The runs that would be executed; the first of them by name.
void PrintDryRun(const plans::SizedPlan& sized, const fs::path& out, const RunArguments& arguments,
                 const plans::RetryChoice& retry) {
  constexpr std::size_t kMostNamed = 20;
  const plan::Plan& plan = sized.plan;
  const std::set<std::string> kept = FindKept(sized, out, arguments, retry);
  std::uint64_t count = 0;
  std::string names;
  plan.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
    if (kept.contains(id) || ++count > kMostNamed) return;
    names += fmt::format("  {}  {}\n", id, plan::Describe(plan, {id, at, rep, {}, {}, {}}));
  });
  const std::uint64_t runs = plan.RunCount();
  if (plan.ChoosesRuns() && count > 0)
    return terminal::Print(
        fmt::format("{}: {} would be executed, as the results of one another ask, into '{}'; {} "
                    "are finished\n",
                    plan.benchmark, searches::RunsText(plan, runs), out.string(), runs - count));
  if (count == 0)
    return terminal::Print(
        fmt::format("{}: every run is finished; nothing would be executed\n", plan.benchmark));
  terminal::Print(
      fmt::format("{}: {} of {} run{} would be executed, into '{}'\n{}{}", plan.benchmark, count,
                  runs, runs == 1 ? "" : "s", out.string(), names,
                  count > kMostNamed ? fmt::format("  and {} more\n", count - kMostNamed) : ""));
  if (!options::IsPlanFile(arguments.file))
    terminal::Print(fmt::format("Time and size: cdb plan --estimate {}\n",
                                terminal::ShellWord(arguments.file)));
}

/// The verdict of --require: nullopt if it is not given.
std::optional<protocol::Verdict> RequiredVerdict(const RunArguments& arguments,
                                                 const std::vector<plans::SizedPlan>& plans) {
  if (arguments.require.empty()) return std::nullopt;
  if (!arguments.shard.empty() || arguments.is_dry)
    throw options::CommandError(
        "--require judges complete results; remove --shard and --dry-run, and repeat the command "
        "with --require after the merge");
  for (const plans::SizedPlan& sized : plans)
    if (!sized.plan.Records("stability"))
      throw options::CommandError(
          fmt::format("--require {}: '{}' does not record stability, and so has no verdicts; "
                      "nothing was started",
                      arguments.require, sized.plan.benchmark));
  std::vector<std::string_view> words;
  for (const protocol::VerdictInfo& info : protocol::Verdicts()) {
    if (info.verdict == protocol::Verdict::kUnknown || protocol::HasVoidTimings(info.verdict))
      continue;
    if (info.name == arguments.require) return info.verdict;
    words.push_back(info.name);
  }
  throw options::CommandError(
      fmt::format("--require {}: {}", arguments.require,
                  options::Suggestion(arguments.require, words,
                                      fmt::format("it takes {}", fmt::join(words, ", ")))));
}

/// Says how many runs are worse than `required`: exit status 3 if there are any.
options::ExitStatus Require(protocol::Verdict required, const fs::path& out) {
  const results::ResultFile file(out, results::ProofOf::kStructure);
  const figures::CellGroups groups = figures::GroupCells(file);
  std::size_t worse = groups.bad.size();
  std::string names;
  const auto add = [&names](std::size_t count, std::string_view what) {
    if (count > 0) names += fmt::format("{}{} {}", names.empty() ? "" : ", ", count, what);
  };
  for (const auto& [verdict, runs] : groups.verdicts)
    if (verdict > required || verdict == protocol::Verdict::kUnknown) {
      worse += runs.size();
      add(runs.size(), protocol::VerdictName(verdict));
    }
  add(groups.bad.size(), "failed or void");
  if (worse == 0) return options::ExitStatus::kGood;
  terminal::Say(fmt::format("{}: {} of {} runs fail `--require {}`: {}\n", out.string(), worse,
                            groups.NotSkipped(), protocol::VerdictName(required), names));
  return options::ExitStatus::kFailedRuns;
}

/// Runs that execute side by side slow each other down, which falsifies their times.
void CheckJobs(const RunArguments& arguments, const std::vector<plans::SizedPlan>& plans) {
  if (arguments.jobs == 1 || arguments.shares_timings) return;
  for (const plans::SizedPlan& sized : plans)
    for (const auto& [word, what] : {std::pair{"timing", "times"}, {"counters", "counters"}})
      if (sized.plan.Records(word) && !plan::CountsInstructions(sized.plan))
        throw options::CommandError(
            fmt::format("--jobs {}: '{}' records {}, which parallel runs disturb; remove --jobs, "
                        "remove {} from `record`, or add --shared-timings if these {} do not "
                        "matter; nothing was started",
                        arguments.jobs, sized.plan.benchmark, what, word, what));
}

options::ExitStatus Run(const RunArguments& arguments) {
  const schedule::ShardChoice shard = ParseShard(arguments.shard);
  plans::RetryChoice retry(arguments.retry);
  if (!retry.is_empty() && (arguments.fresh || !arguments.only.empty()))
    throw options::CommandError(fmt::format(
        "--retry keeps the other runs, but {}; use one of them",
        arguments.fresh ? "--fresh discards all" : "--only executes one run by its id"));
  std::optional<double> until;
  if (arguments.is_dry && (!arguments.shard.empty() || !arguments.until.empty()))
    throw options::CommandError("--dry-run lists all runs; remove --shard and --until");
  if (!arguments.until.empty()) {
    if (!arguments.shard.empty() || !arguments.only.empty() || !retry.is_empty())
      throw options::CommandError(
          "--until needs all repeats of all points; remove --shard, --only and --retry");
    until = options::ParsePercent("--until", arguments.until);
    if (*until == 0) throw options::CommandError("--until 0%: no number of repeats is enough");
  }
  auto plans = PlanOfExisting(arguments);
  if (!plans.empty()) {
    retry = plans::RetryChoice::Only(arguments.only);
  } else {
    plans = !arguments.only.empty()
                ? OnlyRun(arguments)
                : plans::LoadSizedPlans(
                      arguments.file, arguments.benchmark,
                      arguments.quiet ? options::LintText::kNone : options::LintText::kOneLine,
                      arguments.plugins);
  }
  if (plans.empty()) return options::ExitStatus::kScenarioError;
  CheckJobs(arguments, plans);
  const std::optional<protocol::Verdict> required = RequiredVerdict(arguments, plans);
  for (const plans::SizedPlan& sized : plans) {
    if (until) plans::CheckUntil(sized.plan);
    plans::CheckChoice(sized.plan, until.has_value());
  }
  std::vector<fs::path> outs;
  for (const plans::SizedPlan& plan : plans)
    outs.push_back(plans::ResultPath(
        arguments.out, arguments.only.empty() ? plan.plan.benchmark : arguments.only,
        arguments.only.empty() ? arguments.file : std::string(), plans.size()));
  if (arguments.is_dry) {
    for (std::size_t i = 0; i < plans.size(); ++i)
      PrintDryRun(plans[i], outs[i], arguments, plans::RetryChoice(arguments.retry));
    return options::ExitStatus::kGood;
  }
  if (options::BuildType() != "Release" && !arguments.quiet)
    terminal::Say(fmt::format("this is a {} build: its timings are marked as such in the results\n",
                              options::BuildType()));
  const plans::PlanRunner runner({.jobs = arguments.jobs,
                                  .fresh = arguments.fresh,
                                  .is_quiet = arguments.quiet,
                                  .keeps_earlier = arguments.only.empty(),
                                  .shard = shard,
                                  .plugins = arguments.plugins,
                                  .retry = retry,
                                  .noisy_retries = arguments.noisy_retries,
                                  .until = until,
                                  .settings = arguments.settings});
  options::ExitStatus status = options::ExitStatus::kGood;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const options::ExitStatus one = RunPlan(plans[i], outs[i], runner, arguments.quiet);
    if (runner.is_stopped()) return one;
    status = std::max(status, one);
    if (required) status = std::max(status, Require(*required, outs[i]));
  }
  return status;
}

void DeclareRun(options::Subcommand& command) {
  const auto arguments = std::make_shared<RunArguments>();
  command.Required("FILE", arguments->file, "scenario file, or a plan as YAML");
  command.Benchmark(arguments->benchmark);
  command.Out(
      arguments->out,
      "results file, or a folder for them (default: FILE.h5; BENCHMARK.h5 if FILE has several)");
  command.Jobs(arguments->jobs, "number of parallel runs (default: 1), if no times are recorded");
  command.Flag("--shared-timings", arguments->shares_timings,
               "with --jobs: record times although parallel runs disturb them");
  command.Optional("--shard", arguments->shard, "K/N: only the K-th of N parts; merge them later");
  command.Optional(
      "--only", arguments->only,
      "execute only this run, into RUN.h5; or repeat it in -o, if that has the results of "
      "FILE (ids: cdb plan)");
  command.Retry(arguments->retry, "file");
  command.RetryNoisy(arguments->noisy_retries);
  command.Optional("--until", arguments->until,
                   "P%: stop repeating, after 5 repeats or more, once the 95 % interval of every "
                   "mean step is within P % of it; `repeats` is the upper limit");
  command.Optional(
      "--require", arguments->require,
      "exit status 3 also if a run has a worse verdict than this: stable, drifting, …");
  command.Flag("--dry-run", arguments->is_dry,
               "print the runs that would be executed, and what becomes of finished ones; write "
               "nothing");
  command.Fresh(arguments->fresh, "discard results and finished runs and start over");
  command.Quiet(arguments->quiet, "print only errors");
  command.Plugins(arguments->plugins);
  command.Set(arguments->settings);
  command.Action([arguments] {
    options::SetInScenario(arguments->file, arguments->benchmark, arguments->settings);
    return Run(*arguments);
  });
}

}  // namespace

options::Command RunCommand() {
  return {.name = "run",
          .help = "run a scenario file or a plan; resume where it stopped",
          .declare = DeclareRun};
}

}  // namespace cdb::cli
