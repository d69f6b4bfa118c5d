// `cdb merge`: makes a results file from the journals of a sweep.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/retry.h"
#include "runtime/cli/plans/sized_plan.h"
#include "runtime/cli/plans/sweep_files.h"
#include "runtime/figures/points.h"
#include "runtime/printers/document.h"
#include "runtime/results/files/local_disk.h"
#include "runtime/results/journal/journals.h"
#include "runtime/results/store.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct MergeArguments {
  std::string out;
  std::vector<std::string> journals;  ///< or folders of them
  std::uint64_t wait_s = 0;           ///< time to wait for missing runs
  bool removes = false;               ///< remove the folder once all are merged
};

/// The plans that lie beside the journals. A file is listed once.
std::vector<std::string> FindPlans(const std::vector<std::string>& places) {
  std::error_code error;
  std::vector<std::string> plans;
  for (const std::string& place : places) {
    const fs::path folder =
        fs::is_directory(place, error) ? fs::path(place) : fs::path(place).parent_path();
    const std::string beside = plans::FindPlanIn(folder);
    if (!beside.empty() && std::ranges::find(plans, beside) == plans.end()) plans.push_back(beside);
  }
  return plans;
}

/// The one plan of all files. Throws CommandError if there are several.
plans::SizedPlan ReadOnePlan(const std::vector<std::string>& files) {
  const std::string text = options::ReadText(files[0]);
  plans::SizedPlan sized = plans::ReadPlanFile(files[0], text);
  for (const std::string& file : std::span(files).subspan(1)) {
    const std::string other = options::ReadText(file);
    if (other != text && plans::ReadPlanFile(file, other).plan.Sha256() != sized.plan.Sha256())
      throw options::CommandError(
          fmt::format("'{}' and '{}' are two plans, and nothing was merged; a results file is of "
                      "one plan: merge the folders of each by themselves",
                      files[0], file));
  }
  if (sized.plan.version != plan::kPlanVersion)
    throw options::CommandError(fmt::format(
        "'{}' is a plan of format {} of an earlier cdb, which named its runs differently: merge "
        "the runs beside it with that cdb; this one reads the result",
        files[0], sized.plan.version));
  return sized;
}

/// The plan of the journals. A `merge --remove` that was killed may have left a folder without one;
/// the result has it then.
plans::SizedPlan ReadPlanOf(const MergeArguments& arguments) {
  const std::vector<std::string> files = FindPlans(arguments.journals);
  if (!files.empty()) return ReadOnePlan(files);
  std::error_code error;
  if (arguments.removes && fs::is_directory(arguments.journals[0], error) &&
      journal::JournalsIn(arguments.journals[0]).empty() && results::IsStored(arguments.out))
    return plans::ReadSizedPlan(results::ResultFile(arguments.out).ReadProvenance("plan_text"),
                                arguments.out);
  throw options::CommandError(fmt::format(
      "there is no plan.yaml in or beside '{}'; merge takes folders with journals, as `cdb run` "
      "makes them",
      fmt::join(arguments.journals, "', '")));
}

/// Waits until `is_there` returns true or `seconds` have passed. A network file system may show a
/// file of another node only after a while, and sooner if the folder is read.
void WaitForRuns(const std::function<bool()>& is_there, double seconds) {
  constexpr auto kPause = std::chrono::milliseconds(500);
  const auto begin = std::chrono::steady_clock::now();
  while (std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() <
         seconds) {
    if (is_there()) return;
    std::this_thread::sleep_for(kPause);
  }
}

/// Prints the facts about the machines' processors that a reader of the results must know.
void SayProcessors(const results::ResultFile& file) {
  for (const std::string& note : printers::ProcessorNotes(file, figures::AllCells(file)))
    terminal::Say("  " + note + "\n");
}

options::ExitStatus Merge(const MergeArguments& arguments) {
  const plans::SizedPlan sized = ReadPlanOf(arguments);
  const plan::Plan& plan = sized.plan;
  plans::CheckIsOfPlan(arguments.out, plan);
  const std::vector<fs::path> places(arguments.journals.begin(), arguments.journals.end());
  for (const fs::path& place : places) schedule::RefuseEarlierShards(place);
  std::error_code error;
  if (arguments.removes && (places.size() != 1 || !fs::is_directory(places[0], error)))
    throw options::CommandError("--remove goes with one folder of journals");
  std::optional<plans::FolderLock> lock;
  if (arguments.removes) lock.emplace(places[0]);
  const bool is_retry = lock && !plans::FindStartedRetry(places[0]).is_empty();
  const auto count_not_again = [&] {
    return is_retry ? plans::CountNotRunAgain(plan, places[0], arguments.out) : 0;
  };
  const auto is_there = [&] {
    return is_retry ? count_not_again() == 0 : journal::HasAllRuns(plan, places);
  };
  if (!std::ranges::all_of(places, files::IsOnLocalDisk))
    WaitForRuns(is_there, static_cast<double>(arguments.wait_s));
  const std::size_t not_again = count_not_again();
  plans::MergeOnto(plan, places, arguments.out);
  const results::ResultFile file(arguments.out);
  const std::size_t missing = plans::CountMissing(file, plan);
  const std::size_t left_out = plans::CountLeftOut(file, plan);
  const bool removes = lock && missing == 0 && not_again == 0;
  terminal::Say(
      fmt::format("{} of {} runs{} in '{}'{}{}\n", plan.RunCount() - missing - left_out,
                  plan.RunCount(), left_out > 0 ? ", all that are needed," : "", arguments.out,
                  not_again > 0 ? fmt::format(", {} of them still to be run again", not_again) : "",
                  removes ? "" : "; the journals are left where they are"));
  SayProcessors(file);
  if (removes) plans::RemoveMergedRuns(plan, places[0], *lock, /*is_quiet=*/false);
  return options::ExitStatus::kGood;
}

void DeclareMerge(options::Subcommand& command) {
  const auto arguments = std::make_shared<MergeArguments>();
  command.Required("-o,--out", arguments->out, "results file");
  command.Required("RUNS", arguments->journals, "folders of unfinished sweeps, or journals");
  command.Count("--wait", arguments->wait_s,
                "seconds to wait for missing runs, which a network file system may show late");
  command.Flag("--remove", arguments->removes, "remove the folder once all runs are merged");
  command.Action([arguments] { return Merge(*arguments); });
}

}  // namespace

options::Command MergeCommand() {
  return {.name = "merge",
          .help = "merge finished runs into a results file, even if some are missing",
          .declare = DeclareMerge};
}

}  // namespace cdb::cli
