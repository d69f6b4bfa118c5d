// `cdb show`: a results file as tables on the terminal.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "runtime/cli/commands.h"
#include "runtime/cli/subcommand.h"
#include "runtime/report/console.h"
#include "runtime/report/results_document.h"
#include "runtime/report/show.h"
#include "runtime/report/show_error.h"
#include "runtime/store/store.h"

namespace cdb::cli {
namespace {

struct ShowArguments {
  std::string file;
  std::vector<std::string> by;  ///< axes that make the rows
  std::string baseline;     ///< the detector that ratios are to; empty: the first with all cells
  bool only_sound = false;  ///< without runs whose timings a verdict voids
  std::string error;        ///< an array of /accuracy to set against run time; empty: a summary
  std::vector<std::string> each;  ///< with `error`: axes with a table for each value
  bool json = false;              ///< a document instead of tables
};

/// The document is whole; what it is read with chooses rows.
ExitStatus ShowJson(const ShowArguments& arguments) {
  if (!arguments.error.empty() || !arguments.each.empty())
    throw CommandError("--json has the errors and their fronts: leave --error and --each out");
  if (!arguments.by.empty())
    throw CommandError("--json has a row for each point; --by is for tables");
  const store::ResultFile file(arguments.file);
  const report::DocumentText document =
      report::ResultsDocument(file, {.file = std::filesystem::path(arguments.file).filename(),
                                     .baseline = arguments.baseline,
                                     .only_sound = arguments.only_sound});
  report::Print(document.json + "\n");
  return document.bad_cells > 0 ? ExitStatus::kRuns : ExitStatus::kGood;
}

ExitStatus Show(const ShowArguments& arguments) {
  if (arguments.json) return ShowJson(arguments);
  const bool is_summary = arguments.error.empty();
  if (is_summary && !arguments.each.empty())
    throw CommandError("--each goes with --error NAME; a summary takes --by");
  if (!is_summary && !arguments.baseline.empty())
    throw CommandError("--baseline is for the ratios of a summary; --error has none");
  const store::ResultFile file(arguments.file);
  const report::ShowText shown =
      is_summary ? report::Show(file, {arguments.by, arguments.baseline, arguments.only_sound})
                 : report::ShowError(
                       file, {arguments.error, arguments.by, arguments.each, arguments.only_sound});
  report::Print(shown.text);
  return shown.bad_cells > 0 ? ExitStatus::kRuns : ExitStatus::kGood;
}

}  // namespace

void AddShowCommand(CLI::App& app, ExitStatus& status) {
  const auto arguments = std::make_shared<ShowArguments>();
  Subcommand command(app, "show", "a summary of a results file on the terminal");
  command.Required("FILE", arguments->file, "results file");
  command.List("--by", arguments->by, "axes that make the rows (quantity,detector)");
  command.Optional(
      "--baseline", arguments->baseline,
      "the detector that the others are divided by; default: the first with all cells");
  command.Flag("--sound", arguments->only_sound, "without runs whose timings a verdict voids");
  command.Optional("--error", arguments->error,
                   "an error against run time (position, energy: cdb doc accuracy)");
  command.List("--each", arguments->each,
               "with --error: axes each value of which has a table and a front of its own");
  command.Flag("--json", arguments->json, "everything as one JSON document (cdb doc document)");
  command.Action(status, [arguments] { return Show(*arguments); });
}

}  // namespace cdb::cli
