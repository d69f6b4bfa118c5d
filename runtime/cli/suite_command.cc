// `cdb suite`: runs the standard suite, prints its scores, and checks whether results can be
// trusted.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"
#include "runtime/cli/check_stored.h"
#include "runtime/cli/options/provenance.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/plan_runner.h"
#include "runtime/cli/plans/suite_plan.h"
#include "runtime/cli/publish/digest.h"
#include "runtime/cli/publish/place.h"
#include "runtime/cli/publish/publish.h"
#include "runtime/figures/suite.h"
#include "runtime/pages/page/page.h"
#include "runtime/printers/suite.h"
#include "runtime/protocol/bytes_text.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

namespace fs = std::filesystem;

struct SuiteArguments {
  std::vector<std::string> only;  ///< kinds or scenes; empty: all
  std::string out = "suite";      ///< folder of the results
  plans::SuiteChoice choice;
  std::uint64_t seed = 0;          ///< 0: the published seeds
  std::vector<std::string> retry;  ///< retry runs with these endings
  std::uint64_t noisy_retries = 0;
  std::string check, against, publish, page;  ///< folders
  std::string sign;                           ///< file of a key; empty: not signed
  bool fresh = false;
  bool quiet = false;
};

using figures::StandardScene;

/// `games`, `games/debris` or `debris`.
bool Names(const std::string& word, const StandardScene& scene) {
  return word == scene.kind || word == scene.name || word == scene.Id();
}

/// The requested scenes. Throws CommandError for a word that matches none.
std::vector<StandardScene> Chosen(const std::vector<std::string>& only) {
  std::vector<std::string> names;
  for (const figures::SuiteKind& kind : figures::SuiteKinds()) names.emplace_back(kind.name);
  for (const StandardScene& scene : figures::StandardScenes()) {
    names.push_back(scene.Id());
    names.emplace_back(scene.name);
  }
  for (const std::string& word : only) {
    if (std::ranges::find(names, word) != names.end()) continue;
    throw options::CommandError(
        fmt::format("--only {}: the standard suite has no such kind or scene; {}", word,
                    options::Suggestion(word, {names.begin(), names.end()},
                                        fmt::format("it has {}", fmt::join(names, ", ")))));
  }
  std::vector<StandardScene> chosen;
  for (const StandardScene& scene : figures::StandardScenes())
    if (only.empty() ||
        std::ranges::any_of(only, [&](const std::string& word) { return Names(word, scene); }))
      chosen.push_back(scene);
  return chosen;
}

/// True if a run has void timings or none.
bool HasBadRuns(const plans::SuiteFolder& read) {
  for (const figures::SceneFigures& scene : read.scenes)
    for (const figures::ConfigurationFigures& of : scene.configurations)
      if (of.verdict == protocol::Verdict::kUnknown || protocol::HasVoidTimings(of.verdict))
        return true;
  return false;
}

bool HasDisturbedRuns(const plans::SuiteFolder& read) {
  return std::ranges::any_of(read.scenes, [](const figures::SceneFigures& scene) {
    return std::ranges::any_of(scene.configurations, &figures::ConfigurationFigures::is_disturbed);
  });
}

/// The name of the page, or the reason why there is none: the figures do not depend on it.
std::string WritePage(const plans::SuiteFolder& read, const fs::path& folder) {
  try {
    plans::WriteSuiteSummary(read, folder);
    return (folder / plans::kSuitePage).string();
  } catch (const page::PageError& error) {
    return fmt::format("no page: {}", error.what());
  }
}

options::ExitStatus Show(const SuiteArguments& arguments) {
  const fs::path folder = arguments.out;
  const plans::SuiteFolder read = plans::ReadSuiteFolder(folder);
  const std::string page = WritePage(read, folder);
  std::string text = fmt::format("Standard suite {}, {}{}\n\n", figures::kSuiteVersion,
                                 read.facts.is_long ? "long" : "short",
                                 read.facts.seed ? fmt::format(", seed {}", *read.facts.seed) : "");
  text += printers::ScoreText(figures::ScoreKinds(read.scenes));
  text += printers::RecommendationText(read.scenes) + "\n";
  text += terminal::Wrapped(printers::DefaultsText(read.scenes), 0) + "\n";
  if (!read.facts.missing.empty())
    text += terminal::Wrapped(
        fmt::format("Not a complete suite, without {}", fmt::join(read.facts.missing, ", ")), 0);
  if (HasDisturbedRuns(read))
    text += terminal::Wrapped(
        fmt::format("The machine was disturbed (`cdb doctor`); on an idle one, `cdb suite -o {} "
                    "--retry noisy` runs the noisy runs again",
                    terminal::ShellWord(arguments.out)),
        0);
  text += page + "\n";
  if (!arguments.quiet) terminal::Print(text);
  return HasBadRuns(read) ? options::ExitStatus::kFailedRuns : options::ExitStatus::kGood;
}

options::ExitStatus RunSuite(const SuiteArguments& arguments) {
  plans::SuiteChoice choice = arguments.choice;
  if (arguments.seed != 0) choice.seed = arguments.seed;
  if (!arguments.retry.empty() && arguments.fresh)
    throw options::CommandError(
        "--retry keeps the other runs, but --fresh discards all; use one of them");
  if (choice.seed && choice.is_long)
    throw options::CommandError("--long has its own seeds, so it cannot be combined with --seed");
  const auto scenes = Chosen(arguments.only);
  std::vector<plan::Plan> plans;
  for (const StandardScene& scene : scenes) plans.push_back(plans::StandardPlan(scene, choice));
  plans::MakeResultsFolder(arguments.out);
  if (options::BuildType() != "Release" && !arguments.quiet)
    terminal::Say(fmt::format("this is a {} build: its timings are marked as such in the results\n",
                              options::BuildType()));
  plans::PlanRunnerOptions options;
  options.fresh = arguments.fresh;
  options.is_quiet = arguments.quiet;
  options.plugins = choice.plugins;
  options.retry = plans::RetryChoice(arguments.retry);
  options.noisy_retries = arguments.noisy_retries;
  const plans::PlanRunner runner(options);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    if (!arguments.quiet)
      terminal::Say(
          fmt::format("{} ({} of {}): {}\n", scenes[i].Id(), i + 1, plans.size(), scenes[i].what));
    const plans::ExecutedPlan end =
        runner.Execute(plans[i], fs::path(arguments.out) / scenes[i].ResultName());
    if (end.summary.signal != 0) return runner.StoppedStatus();
  }
  return Show(arguments);
}

/// The signature and the digest of published results, for `--check`.
void CheckPublished(const fs::path& folder, plans::SuiteFaults& made) {
  if (!publish::IsPublished(folder)) return;
  for (const std::string& fault : publish::FindDigestFaults(folder)) made.faults.push_back(fault);
  const publish::Signature signature = publish::CheckSignature(folder);
  if (signature.state == publish::SignatureState::kBad)
    made.faults.push_back(signature.text);
  else
    made.facts.push_back("signature: " + signature.text);
}

options::ExitStatus Check(const fs::path& folder) {
  options::ExitStatus status = options::ExitStatus::kGood;
  std::error_code error;
  for (const StandardScene& scene : figures::StandardScenes())
    if (const fs::path file = folder / scene.ResultName(); fs::exists(file, error))
      status = std::max(status, CheckStored(file.string()));
  if (status == options::ExitStatus::kEnvironmentError) return status;
  const plans::SuiteFolder read = plans::ReadSuiteFolder(folder);
  plans::SuiteFaults made = plans::CheckSuite(read, folder);
  CheckPublished(folder, made);
  std::string text = "\n";
  for (const std::string& fact : made.facts) text += terminal::Wrapped(fact, 2);
  text += made.faults.empty()
              ? fmt::format("\nComplete and comparable: version {} of the suite, {}\n",
                            figures::kSuiteVersion, read.facts.is_long ? "long" : "short")
              : "\nNot complete and comparable:\n";
  for (const std::string& fault : made.faults) text += terminal::Wrapped(fault, 2);
  terminal::Print(text);
  return made.faults.empty() ? options::ExitStatus::kGood : options::ExitStatus::kFailedRuns;
}

/// `NAME: REASON`, with the number of the other reasons.
std::string FirstOf(const std::string& name, const std::vector<std::string>& reasons) {
  const std::string more =
      reasons.size() > 1 ? fmt::format("; and {} more", reasons.size() - 1) : std::string();
  return terminal::Wrapped(fmt::format("{}: {}{}", name, reasons[0], more), 0);
}

/// Writes the page of a place. Prints a line for each entry that is not sound, and for each that
/// another one contradicts.
options::ExitStatus WritePlace(const fs::path& folder) {
  const publish::Place place = publish::ReadPlace(folder);
  std::string text;
  std::size_t faulty = 0, disagreements = 0;
  for (const publish::PlaceEntry& entry : place.entries) {
    faulty += !entry.faults.empty();
    if (!entry.faults.empty()) text += FirstOf(entry.name, entry.faults);
    for (const publish::Verification& of : entry.verified) {
      if (of.outcome != publish::Verification::Outcome::kDisagrees) continue;
      ++disagreements;
      text += FirstOf(fmt::format("{} is contradicted by {}", entry.name, of.by), of.reasons);
    }
  }
  for (const auto& [name, why] : place.left_out)
    text += fmt::format("{}: left out: {}\n", name, why);
  std::string page = (folder / publish::kPlacePage).string();
  bool is_written = true;
  try {
    publish::WritePlacePage(place, folder);
  } catch (const page::PageError& error) {
    page = fmt::format("no page: {}", error.what());
    is_written = false;
  }
  const std::size_t entries = place.entries.size();
  text += fmt::format("{}: {} entr{}{}{}\n", page, entries, entries == 1 ? "y" : "ies",
                      faulty > 0 ? fmt::format(", {} of them not sound", faulty) : "",
                      disagreements > 0 ? fmt::format(", {} disagreements", disagreements) : "");
  terminal::Print(text);
  return !is_written         ? options::ExitStatus::kEnvironmentError
         : faulty > 0        ? options::ExitStatus::kFailedRuns
         : disagreements > 0 ? options::ExitStatus::kWorse
                             : options::ExitStatus::kGood;
}

options::ExitStatus Publish(const SuiteArguments& arguments) {
  using Outcome = publish::Published::Outcome;
  const fs::path folder = arguments.out;
  plans::RequireThisVersion(folder);
  const publish::CheckedResults checked = publish::CheckResults(folder);
  if (!checked.faults.empty()) {
    std::string text =
        fmt::format("{}: not published, because not complete and comparable:\n", folder.string());
    for (const std::string& fault : checked.faults) text += terminal::Wrapped(fault, 2);
    terminal::Print(text);
    return options::ExitStatus::kFailedRuns;
  }
  const publish::Published made =
      publish::Publish(checked, folder, arguments.publish, arguments.sign);
  terminal::Print(fmt::format(
      "{}: {}, {}\n", made.folder.string(),
      made.outcome == Outcome::kNew
          ? fmt::format("published: {} files, {}", made.files, protocol::BytesText(made.bytes))
      : made.outcome == Outcome::kSigned ? "was published already"
                                         : "was published already; nothing changed",
      publish::CheckSignature(made.folder).text));
  static_cast<void>(WritePlace(arguments.publish));  // other entries may have faults
  return options::ExitStatus::kGood;
}

options::ExitStatus Against(const fs::path& other, const fs::path& mine) {
  for (const fs::path& folder : {other, mine}) {
    plans::RequireThisVersion(folder);
    publish::RequireAsPublished(folder);
  }
  const plans::SuiteFolder claimed = plans::ReadSuiteFolder(other),
                           here = plans::ReadSuiteFolder(mine);
  std::vector<figures::SceneVerification> verified;
  std::vector<std::string> unverified;
  for (std::size_t i = 0; i < claimed.scenes.size(); ++i) {
    const auto same = std::ranges::find_if(here.scenes, [&](const figures::SceneFigures& scene) {
      return scene.scene->Id() == claimed.scenes[i].scene->Id();
    });
    if (same == here.scenes.end()) {
      unverified.push_back(claimed.scenes[i].scene->Id());
      continue;
    }
    const auto place = static_cast<std::size_t>(same - here.scenes.begin());
    verified.push_back(
        figures::VerifyScene({*claimed.files[i], claimed.scenes[i]}, {*here.files[place], *same}));
  }
  std::string text = fmt::format("{} verified by {}\n{}", other.string(), mine.string(),
                                 printers::VerificationText(verified));
  if (!unverified.empty())
    text += terminal::Wrapped(fmt::format("Not verified, because not in '{}': {}", mine.string(),
                                          fmt::join(unverified, ", ")),
                              2);
  terminal::Print(text);
  const bool disagrees = std::ranges::any_of(verified, [](const auto& of) {
    return of.outcome == figures::SceneVerification::Outcome::kDisagrees;
  });
  const bool is_whole = unverified.empty() && std::ranges::all_of(verified, [](const auto& of) {
                          return of.claimed > 0 && of.timed == of.claimed;
                        });
  return disagrees  ? options::ExitStatus::kWorse
         : is_whole ? options::ExitStatus::kGood
                    : options::ExitStatus::kFailedRuns;
}

options::ExitStatus Suite(const SuiteArguments& arguments) {
  const std::pair<const char*, const std::string*> actions[] = {{"--check", &arguments.check},
                                                                {"--against", &arguments.against},
                                                                {"--publish", &arguments.publish},
                                                                {"--page", &arguments.page}};
  std::vector<const char*> chosen;
  for (const auto& [name, folder] : actions)
    if (!folder->empty()) chosen.push_back(name);
  if (chosen.size() > 1)
    throw options::CommandError(fmt::format("{} cannot be combined with {}", chosen[0], chosen[1]));
  const plans::SuiteChoice& choice = arguments.choice;
  const std::pair<const char*, bool> of_runs[] = {{"--only", !arguments.only.empty()},
                                                  {"--long", choice.is_long},
                                                  {"--seed", arguments.seed != 0},
                                                  {"--detector", !choice.detectors.empty()},
                                                  {"--plugin", !choice.plugins.empty()},
                                                  {"--retry", !arguments.retry.empty()},
                                                  {"--retry-noisy", arguments.noisy_retries > 0},
                                                  {"--fresh", arguments.fresh},
                                                  {"--quiet", arguments.quiet}};
  for (const auto& [name, is_given] : of_runs)
    if (is_given && !chosen.empty())
      throw options::CommandError(
          fmt::format("{} is for runs, and {} executes none; remove it", name, chosen[0]));
  if (arguments.out != SuiteArguments().out &&
      (!arguments.check.empty() || !arguments.page.empty()))
    throw options::CommandError(
        fmt::format("-o is not used by {}, which has a folder of its own; remove it", chosen[0]));
  if (!arguments.sign.empty() && arguments.publish.empty())
    throw options::CommandError("--sign signs what is published: it needs --publish");
  if (!arguments.check.empty()) return Check(arguments.check);
  if (!arguments.publish.empty()) return Publish(arguments);
  if (!arguments.page.empty()) return WritePlace(arguments.page);
  if (!arguments.against.empty()) return Against(arguments.against, arguments.out);
  return RunSuite(arguments);
}

void DeclareSuite(options::Subcommand& command) {
  const auto arguments = std::make_shared<SuiteArguments>();
  command.Out(arguments->out, "folder for the results (default: suite)");
  command.List("--only", arguments->only,
               "only these kinds or scenes: games, stiff/stack (default: all)");
  command.Flag("--long", arguments->choice.is_long, "three seeds and more repeats, about an hour");
  command.Count("--seed", arguments->seed, "another seed, to verify results of the published seed");
  command.List("--detector", arguments->choice.detectors,
               "additional detectors, beside those of the suite");
  command.Plugins(arguments->choice.plugins);
  command.Retry(arguments->retry, "files");
  command.RetryNoisy(arguments->noisy_retries);
  command.Optional("--check", arguments->check,
                   "check whether the results in this folder are complete and comparable");
  command.Optional("--against", arguments->against,
                   "verify the results of another machine, in this folder, against those of -o");
  command.Optional("--publish", arguments->publish,
                   "add the results in -o to this folder of many machines, and write its page");
  command.Optional("--sign", arguments->sign,
                   "sign what is published with this key of ssh, by ssh-keygen");
  command.Optional("--page", arguments->page,
                   "check all results in this folder of many machines, and write its page");
  command.Fresh(arguments->fresh, "discard results and start over");
  command.Quiet(arguments->quiet, "print only errors");
  command.Action([arguments] { return Suite(*arguments); });
}

}  // namespace

/// Runs the standard suite and prints a score for each configuration and kind of application, or
/// checks or publishes results of the suite. Safe to rerun: finished runs are skipped. Exit status
/// 3 if runs failed or results are not comparable, 4 if the results of another machine disagree.
options::Command SuiteCommand() {
  return {.name = "suite",
          .help = "run the standard suite, and score each configuration",
          .declare = DeclareSuite};
}

}  // namespace cdb::cli
