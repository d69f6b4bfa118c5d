#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>

#include "compiler/plan/plan_yaml.h"
#include "compiler/plan/reference.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/plan_runner.h"
#include "runtime/cli/provenance.h"
#include "runtime/report/console.h"
#include "runtime/report/show.h"
#include "runtime/report/show_error.h"
#include "runtime/store/store.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

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
  throw CommandError(
      fmt::format("--shard {} is not K/N: the K-th of N parts, from 1/N to N/N", text));
}

fs::path ResultPath(const RunArguments& arguments, const plan::Plan& plan, std::size_t plan_count) {
  std::error_code error;
  const std::string file = (arguments.only.empty() ? plan.benchmark : arguments.only) + ".h5";
  if (arguments.out.empty()) return file;
  if (fs::is_directory(arguments.out, error)) return fs::path(arguments.out) / file;
  if (plan_count > 1)
    throw CommandError(fmt::format(
        "{} has {} benchmarks and '{}' holds one: name a folder, or choose a benchmark by -b",
        arguments.file, plan_count, arguments.out));
  const fs::path folder = fs::path(arguments.out).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error))
    throw CommandError(fmt::format("there is no folder '{}' for '{}'; make it first",
                                   folder.string(), arguments.out));
  return arguments.out;
}

/// The run `id` of one of `plans` as a plan of its own, called like the run.
plan::Plan OnlyRun(const std::vector<plan::Plan>& plans, const std::string& id) {
  for (const plan::Plan& plan : plans) {
    const auto found = std::ranges::find(plan.runs, id, &plan::Run::id);
    if (found == plan.runs.end()) continue;
    plan::Plan one = plan;
    one.title = fmt::format("{}: {}", plan.benchmark, plan::Describe(plan, *found));
    one.repeats = 1;
    one.skipped.clear();
    for (std::size_t i = 0; i < one.axes.size(); ++i)
      one.axes[i].values = {plan.axes[i].values[found->at[i]]};
    plan::Run run = *found;
    run.at.assign(one.axes.size(), 0);
    run.rep = 0;
    run.id = plan::RunId(run.scene, run.rep);
    one.runs = {run};
    plan::AddReferences(one);
    return one;
  }
  throw CommandError(fmt::format("no run has the id '{}'; `cdb plan` lists them", id));
}

int ShowResult(const fs::path& out, bool quiet) {
  const report::ShowText shown = report::Show(store::ResultFile(out));
  if (!quiet) report::Print(fmt::format("{}\n{}\n", shown.text, out.string()));
  return shown.bad_cells > 0 ? kExitRuns : kExitGood;
}

int RunPlan(const plan::Plan& plan, const fs::path& out, const PlanRunner& runner, bool is_quiet) {
  const ExecutedPlan end = runner.CarryOut(plan, out);
  if (end.summary.signal != 0) return runner.StoppedStatus();
  if (end.is_merged) return ShowResult(out, is_quiet);
  if (!is_quiet)
    report::Print(fmt::format("{}\nwhen every shard is done: cdb merge -o {} {}\n",
                              schedule::Describe(end.summary), out.string(), end.shards.string()));
  return end.summary.HasBadRuns() ? kExitRuns : kExitGood;
}

}  // namespace

int RunCommand(const RunArguments& arguments) {
  const schedule::ShardChoice shard = ParseShard(arguments.shard);
  auto plans = LoadPlans(arguments.file, arguments.benchmark,
                         arguments.quiet ? LintText::kNone : LintText::kOneLine, arguments.plugins);
  if (plans.empty()) return kExitScenario;
  if (!arguments.only.empty()) plans = {OnlyRun(plans, arguments.only)};
  std::vector<fs::path> outs;
  for (const plan::Plan& plan : plans) outs.push_back(ResultPath(arguments, plan, plans.size()));
  if (BuildType() != "Release" && !arguments.quiet)
    report::Say(fmt::format("this is a {} build: its timings are marked as such in the results\n",
                            BuildType()));
  const PlanRunner runner(
      {arguments.jobs, arguments.fresh, arguments.quiet, shard, arguments.plugins});
  int status = kExitGood;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const int one = RunPlan(plans[i], outs[i], runner, arguments.quiet);
    if (runner.is_stopped()) return one;
    status = std::max(status, one);
  }
  return status;
}

int ShowCommand(const ShowArguments& arguments) {
  if (arguments.error.empty() && !arguments.each.empty())
    throw CommandError("--each goes with --error NAME; a summary takes --by");
  const store::ResultFile file(arguments.file);
  const report::ShowText shown =
      arguments.error.empty()
          ? report::Show(file, {arguments.by})
          : report::ShowError(file, {arguments.error, arguments.by, arguments.each});
  report::Print(shown.text);
  return shown.bad_cells > 0 ? kExitRuns : kExitGood;
}

int MergeCommand(const std::string& out, const std::vector<std::string>& shards) {
  // The plan lies beside the shards of a run.
  std::error_code error;
  std::string plan_file;
  std::vector<fs::path> places;
  for (const std::string& place : shards) {
    places.emplace_back(place);
    const fs::path folder =
        fs::is_directory(place, error) ? fs::path(place) : fs::path(place).parent_path();
    const fs::path beside = folder / "plan.yaml";
    if (plan_file.empty() && fs::exists(beside, error)) plan_file = beside.string();
  }
  if (plan_file.empty())
    throw CommandError(fmt::format(
        "there is no plan.yaml in or beside '{}'; merge takes the folders that shards are in, as "
        "`cdb run` makes them",
        fmt::join(shards, "', '")));
  const plan::Plan plan = plan::FromYaml(ReadText(plan_file), plan_file);
  if (fs::exists(out, error)) {
    const store::ResultFile there{out};
    if (there.plan_sha256() != plan.Sha256())
      throw CommandError(fmt::format(
          "'{}' holds the results of another plan and is left as it is; name another file", out));
  }
  store::Merge(plan, CollectProvenance(), places, out);
  const store::ResultFile file{out};
  std::size_t missing = 0;
  for (const plan::Run& run : plan.runs)
    if (file.ReadStatus({run.at, run.rep}) == store::Status::kMissing) ++missing;
  report::Say(fmt::format("{} of {} runs in '{}'; the shards are left where they are\n",
                          plan.runs.size() - missing, plan.runs.size(), out));
  return kExitGood;
}

}  // namespace cdb::cli
