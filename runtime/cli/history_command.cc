// `cdb history`: what changed over the results files of many commits, and when.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/git_log.h"
#include "runtime/cli/plans/history_folder.h"
#include "runtime/cli/report_page.h"
#include "runtime/figures/history/histories.h"
#include "runtime/printers/history.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

struct HistoryArguments {
  std::string folder;
  std::string least, since, fail_above;  ///< empty: the default, the first file, no limit
  std::string repository;                ///< empty: files are in order of time
  std::string out;                       ///< the page; empty: history.html
  bool is_json = false, is_page = false;
};

/// The place of the file with this label. Throws CommandError.
double PlaceOfLabel(const std::string& label, const std::vector<history::History>& histories) {
  std::vector<std::string_view> known;
  for (const history::History& of : histories)
    for (std::size_t i = 0; i < of.files.size(); ++i) {
      if (of.labels[i] == label || of.files[i]->file == label) return of.files[i]->place;
      known.push_back(of.labels[i]);
    }
  throw options::CommandError(fmt::format(
      "--since {}: there is no file with this label; {}", label,
      options::Suggestion(label, known, "the labels are in the output without --since")));
}

options::ExitStatus ShowHistory(const HistoryArguments& arguments) {
  history::HistoryOptions options;
  if (!arguments.least.empty())
    options.least_effect = options::ParsePercent("--least", arguments.least);
  printers::PrintedHistories printed;
  if (!arguments.fail_above.empty())
    printed.fail_above = options::ParsePercent("--fail-above", arguments.fail_above);
  options::CheckOneForm({{"--json", arguments.is_json}, {"--page", arguments.is_page}});
  if (!arguments.out.empty() && !arguments.is_page)
    throw options::CommandError("-o names the page: it needs --page");
  plans::HistoryFolder read = plans::ReadHistoryFolder(arguments.folder);
  if (read.files.empty() && read.left_out.empty())
    throw options::CommandError(
        fmt::format("there is no results file (.h5) in {}", arguments.folder));
  printed.files = read.files.size();
  if (!arguments.repository.empty()) {
    printed.commits = plans::ReadCommits(arguments.repository);
    plans::PlaceByCommits(printed.commits, read);
  }
  printed.folder = arguments.folder;
  printed.histories = history::MakeHistories(read.files, options);
  for (const plans::HistoryFolder::LeftOut& of : read.left_out)
    printed.left_out.emplace_back(of.file, of.why);
  printed.read = read.read;
  if (!arguments.since.empty()) printed.since = PlaceOfLabel(arguments.since, printed.histories);
  if (!read.cache_trouble.empty())
    terminal::Say(
        fmt::format("without a cache, each call reads all files: {}\n", read.cache_trouble));
  if (arguments.is_page) {
    WriteReportPage(arguments.out.empty() ? "history.html" : arguments.out,
                    fmt::format("History of {}", arguments.folder),
                    fmt::format("{{\"history\":{}}}", printers::HistoriesPageJson(printed)), {});
  } else if (arguments.is_json) {
    terminal::PrintJson(printers::HistoriesJson(printed));
  } else {
    terminal::Print(
        printers::TextOf(printers::HistoriesDocument(printed), printers::Format::kWrapped));
  }
  return printed.IsFailed() ? options::ExitStatus::kWorse : options::ExitStatus::kGood;
}

void DeclareHistory(options::Subcommand& command) {
  const auto arguments = std::make_shared<HistoryArguments>();
  command.Required("FOLDER", arguments->folder,
                   "folder of results files, one or more for each commit");
  command.Optional("--least", arguments->least,
                   "the least change that is reported (default: 1%, and 0.1% of instructions)");
  command.Optional("--since", arguments->since,
                   "only changes after this file, by its label (default: the first)");
  command.Optional("--fail-above", arguments->fail_above,
                   "exit status 4 if the changes since then make a figure worse by more than this");
  command.Optional(
      "--git", arguments->repository,
      "order the files by the commits of this repository, which their names have, not by "
      "time");
  command.Flag("--json", arguments->is_json, "print JSON, for scripts");
  command.Flag("--page", arguments->is_page, "write a page of figures for a browser");
  command.Out(arguments->out, "the page (default: history.html)");
  command.Action([arguments] { return ShowHistory(*arguments); });
}

}  // namespace

/// Prints steps and drifts of times and memory, and changes of the motion, over the results files
/// of a folder. Exit status 4 if a figure became worse by more than --fail-above.
options::Command HistoryCommand() {
  return {.name = "history",
          .help = "report what changed over the results of many commits, and when",
          .declare = DeclareHistory};
}

}  // namespace cdb::cli
