// `cdb merge`: a results file from the shards of a run.
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "runtime/cli/commands.h"
#include "runtime/cli/inputs.h"
#include "runtime/cli/provenance.h"
#include "runtime/cli/sized_plan.h"
#include "runtime/cli/subcommand.h"
#include "runtime/report/console.h"
#include "runtime/store/store.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct MergeArguments {
  std::string out;
  std::vector<std::string> shards;  ///< shards, or folders of them
};

/// The plans that lie beside the shards of runs, the same file once.
std::vector<std::string> FindPlans(const std::vector<std::string>& shards) {
  std::error_code error;
  std::vector<std::string> plans;
  for (const std::string& place : shards) {
    const fs::path folder =
        fs::is_directory(place, error) ? fs::path(place) : fs::path(place).parent_path();
    const std::string beside = (folder / "plan.yaml").string();
    if (fs::exists(beside, error) && std::ranges::find(plans, beside) == plans.end())
      plans.push_back(beside);
  }
  if (!plans.empty()) return plans;
  throw CommandError(fmt::format(
      "there is no plan.yaml in or beside '{}'; merge takes the folders that shards are in, as "
      "`cdb run` makes them",
      fmt::join(shards, "', '")));
}

/// The one plan of all files. Throws CommandError where they are of several.
SizedPlan ReadOnePlan(const std::vector<std::string>& files) {
  const std::string text = ReadText(files[0]);
  SizedPlan sized = ReadSizedPlan(text, files[0]);
  for (const std::string& file : std::span(files).subspan(1)) {
    const std::string other = ReadText(file);
    if (other != text && ReadSizedPlan(other, file).plan.Sha256() != sized.plan.Sha256())
      throw CommandError(
          fmt::format("'{}' and '{}' are two plans, and nothing was merged; a results file is of "
                      "one plan: merge the shards of each by themselves",
                      files[0], file));
  }
  return sized;
}

/// Empty where it cannot be read.
std::string PlanOf(const std::string& results) {
  try {
    return store::ResultFile(results, store::ProofOf::kStructure).plan_sha256();
  } catch (const store::StoreError&) {
    return {};
  }
}

/// Throws CommandError where `out` holds the results of another plan.
void CheckIsOfPlan(const std::string& out, const plan::Plan& plan) {
  std::error_code error;
  if (!fs::exists(out, error)) return;
  const std::string sha256 = PlanOf(out);
  if (sha256 == plan.Sha256()) return;
  if (sha256.empty())
    throw CommandError(
        fmt::format("'{}' is there, and is no results file or a damaged one; it is left as it is: "
                    "remove it, or name another file (-o)",
                    out));
  throw CommandError(fmt::format(
      "'{}' holds the results of another plan and is left as it is; name another file", out));
}

std::size_t CountMissing(const store::ResultFile& file, const plan::Plan& plan) {
  std::size_t missing = 0;
  plan.ForEachRun([&](const std::string&, const auto& at, std::uint64_t rep) {
    missing += file.ReadStatus({at, rep}) == store::Status::kMissing;
  });
  return missing;
}

ExitStatus Merge(const MergeArguments& arguments) {
  const SizedPlan sized = ReadOnePlan(FindPlans(arguments.shards));
  const plan::Plan& plan = sized.plan;
  CheckIsOfPlan(arguments.out, plan);
  const std::vector<fs::path> places(arguments.shards.begin(), arguments.shards.end());
  store::Merge(plan, CollectProvenance(), places, arguments.out);
  const std::size_t missing = CountMissing(store::ResultFile(arguments.out), plan);
  report::Say(fmt::format("{} of {} runs in '{}'; the shards are left where they are\n",
                          plan.RunCount() - missing, plan.RunCount(), arguments.out));
  return ExitStatus::kGood;
}

}  // namespace

void AddMergeCommand(CLI::App& app, ExitStatus& status) {
  const auto arguments = std::make_shared<MergeArguments>();
  Subcommand command(app, "merge", "merge shards into a results file, all of them or not");
  command.Required("-o,--out", arguments->out, "results file");
  command.Required("SHARDS", arguments->shards, "folders of shards, or shards");
  command.Action(status, [arguments] { return Merge(*arguments); });
}

}  // namespace cdb::cli
