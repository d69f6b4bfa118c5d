// `cdb show`: prints a results file as tables, or as CSV or JSON for scripts.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/result_names.h"
#include "runtime/figures/points.h"
#include "runtime/printers/results_document.h"
#include "runtime/printers/show.h"
#include "runtime/results/store.h"
#include "runtime/terminal/console.h"

namespace cdb::cli {
namespace {

struct ShowArguments {
  std::string file;
  std::vector<std::string> by;  ///< axes that make the rows
  std::string baseline;     ///< the baseline of ratios; empty: the first detector with all cells
  bool only_sound = false;  ///< leave out runs whose timings are voided by their verdict
  std::string error;        ///< an array of /accuracy to set against run time; empty: a summary
  std::string table;        ///< a figure for one table; empty: none
  std::string columns;      ///< with `table`: the axis across
  std::vector<std::string> each;    ///< with `error`: axes with a table for each value
  std::vector<std::string> select;  ///< `axis=value`
  std::vector<std::string> phases;  ///< empty: all
  std::string statistic;            ///< over the cycles; empty: the mean
  std::string budget;               ///< a time per cycle, `4ms`; empty: none
  bool plots = false;
  bool method = false;  ///< only the sentences on the method
  bool all = false;     ///< not only the conclusions and one table
  bool csv = false, json = false, is_junit = false, is_markdown = false, is_latex = false;
};

/// An option, whether it is given, and the reason why it does not go with the form of output.
struct Misfit {
  bool is_given;
  const char* why;
};

void CheckMisfits(std::initializer_list<Misfit> misfits) {
  for (const Misfit& misfit : misfits)
    if (misfit.is_given) throw options::CommandError(misfit.why);
}

/// Throws CommandError for options that have no effect on one table, or need one.
void CheckTable(const ShowArguments& a) {
  if (a.table.empty())
    return CheckMisfits({{!a.columns.empty(), "--columns needs --table FIGURE"}});
  CheckMisfits({{a.json || a.csv,
                 "--table prints a table; --json and --csv have a row for each "
                 "point"},
                {!a.error.empty() || !a.each.empty(),
                 "--table takes the name of an error, too; remove --error and --each"},
                {!a.budget.empty(), "--table and --budget are different tables; remove one"},
                {!a.phases.empty(), "--table takes the name of a phase; remove --phase"},
                {a.plots, "--table has no plots; remove --plot"},
                {a.all, "--table is one table; remove --all"}});
}

/// Throws CommandError for options that have no effect on the sentences on the method.
void CheckMethod(const ShowArguments& a) {
  const bool has_tables = !a.table.empty() || !a.error.empty() || !a.budget.empty() ||
                          !a.by.empty() || !a.phases.empty() || !a.statistic.empty() ||
                          !a.baseline.empty() || a.plots || a.all;
  CheckMisfits({{a.csv, "--method prints sentences; remove --csv"},
                {a.json, "--json has the method; remove --method"},
                {has_tables, "--method prints sentences; remove the options of tables"}});
}

/// Throws CommandError for options that have no effect on test cases.
void CheckJunit(const ShowArguments& a) {
  const bool has_tables = !a.table.empty() || !a.error.empty() || !a.budget.empty() ||
                          !a.by.empty() || !a.phases.empty() || !a.statistic.empty() ||
                          !a.baseline.empty() || a.plots || a.all || a.method || a.only_sound;
  CheckMisfits({{has_tables,
                 "--junit has the requirements of the scenario; remove the options of "
                 "tables"}});
}

/// Throws CommandError for options that have no effect on the chosen output.
void CheckOptions(const ShowArguments& a) {
  options::CheckOneForm({{"--json", a.json},
                         {"--csv", a.csv},
                         {"--junit", a.is_junit},
                         {"--markdown", a.is_markdown},
                         {"--latex", a.is_latex}});
  if (a.method) CheckMethod(a);
  if (a.is_junit) CheckJunit(a);
  CheckTable(a);
  if (a.json)
    CheckMisfits(
        {{!a.error.empty() || !a.each.empty(),
          "--json has all errors and fronts; remove --error and --each"},
         {!a.by.empty(), "--json has a row for each point; --by is for tables"},
         {!a.phases.empty(), "--json has all phases; --phase is for tables and --csv"},
         {!a.statistic.empty(), "--json has all statistics; --stat is for tables and --csv"},
         {a.plots, "--json has no plots; remove --plot"},
         {a.all, "--json has everything; remove --all"}});
  if (a.csv)
    CheckMisfits({{!a.error.empty() || !a.each.empty(),
                   "--csv has a column for each error; remove --error and --each"},
                  {!a.by.empty(), "--csv has a row for each point; --by is for tables"},
                  {!a.baseline.empty(), "--csv has no ratios; --baseline is for tables and --json"},
                  {a.plots, "--csv has no plots; remove --plot"},
                  {a.all, "--csv has everything of its points; remove --all"}});
  if (!a.budget.empty())
    CheckMisfits({{a.json || a.csv, "--budget prints a table; --json and --csv have the times"},
                  {!a.error.empty(), "--budget is for times; remove --error"},
                  {!a.by.empty(), "--budget has a row for each point; remove --by"},
                  {!a.baseline.empty(), "--budget has no ratios; remove --baseline"},
                  {!a.statistic.empty(), "--budget is for the 99th percentile; remove --stat"},
                  {a.plots, "--budget has no plots; remove --plot"},
                  {a.all, "--budget is one table; remove --all"},
                  {a.phases.size() > 1, "--budget is for one phase"}});
  if (a.error.empty()) {
    CheckMisfits({{!a.each.empty(), "--each needs --error NAME; a summary takes --by"}});
    return;
  }
  CheckMisfits(
      {{!a.baseline.empty(), "--baseline is for the ratios of a summary; --error has none"},
       {!a.phases.empty(), "--phase is for a summary; --error is against the time of a step"},
       {!a.statistic.empty(),
        "--stat is for a summary; --error uses the mean, as a simulated second consists of all of "
        "its cycles"},
       {a.plots, "--error always has a plot; remove --plot"}});
}

/// The index of `name` in `names`. Throws CommandError that lists them.
std::size_t PlaceOf(std::string_view option, const std::string& name,
                    std::span<const std::string_view> names) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    throw options::CommandError(
        fmt::format("{} takes {}, not '{}'", option, fmt::join(names, ", "), name));
  return static_cast<std::size_t>(found - names.begin());
}

std::vector<protocol::Phase> PhasesOf(const ShowArguments& arguments) {
  std::vector<protocol::Phase> phases;
  for (const std::string& name : arguments.phases)
    phases.push_back(
        static_cast<protocol::Phase>(PlaceOf("--phase", name, protocol::PhaseNames())));
  return phases;
}

figures::CycleStatistic StatisticOf(const ShowArguments& arguments) {
  if (arguments.statistic.empty()) return figures::CycleStatistic::kMean;
  return static_cast<figures::CycleStatistic>(
      PlaceOf("--stat", arguments.statistic, figures::CycleStatisticNames()));
}

printers::Format FormatOf(const ShowArguments& arguments) {
  return arguments.is_markdown ? printers::Format::kMarkdown
         : arguments.is_latex  ? printers::Format::kLatex
                               : printers::Format::kTerminal;
}

/// A time such as `4ms` or `4 ms`, in ns. Throws CommandError.
double ParseBudget(const std::string& text) {
  const std::size_t digits = text.find_first_not_of("0123456789.");
  double value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + std::min(digits, text.size()), value);
  std::string unit = digits == text.npos ? "" : text.substr(digits);
  unit.erase(0, unit.find_first_not_of(' '));
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"ns", 1}, {"us", 1e3}, {"ms", 1e6}, {"s", 1e9}};
  const auto found = std::ranges::find(kUnits, unit, [](const auto& each) { return each.first; });
  if (error != std::errc{} || !(value > 0) || found == std::end(kUnits))
    throw options::CommandError(
        fmt::format("--budget takes a time with a unit, such as 4ms or 500us, not '{}'", text));
  return value * found->second;
}

/// True unless an option asks for certain tables.
bool IsBrief(const ShowArguments& a) {
  return !a.all && a.by.empty() && a.baseline.empty() && a.phases.empty() && a.statistic.empty() &&
         !a.plots && !a.is_markdown && !a.is_latex;
}

printers::Printed PrintedOf(const results::ResultFile& file, const ShowArguments& arguments) {
  if (arguments.json) {
    printers::Printed document = printers::ResultsDocument(
        file, {.file = std::filesystem::path(arguments.file).filename().string(),
               .baseline = arguments.baseline,
               .only_sound = arguments.only_sound});
    document.text += '\n';
    return document;
  }
  if (arguments.is_junit) return printers::JunitText(file);
  if (arguments.method) return printers::ShowMethod(file, FormatOf(arguments));
  if (!arguments.error.empty())
    return printers::ShowError(file, {{arguments.error, arguments.by, arguments.each},
                                      arguments.only_sound,
                                      FormatOf(arguments)});
  const std::vector<protocol::Phase> phases = PhasesOf(arguments);
  if (!arguments.budget.empty())
    return printers::ShowBudget(file, {{ParseBudget(arguments.budget)},
                                       phases.empty() ? protocol::Phase::kStep : phases.front(),
                                       arguments.only_sound,
                                       FormatOf(arguments)});
  const figures::CycleStatistic statistic = StatisticOf(arguments);
  if (!arguments.table.empty())
    return printers::ShowTable(
        file, {arguments.table, arguments.by, arguments.columns, arguments.baseline,
               arguments.only_sound, statistic, FormatOf(arguments)});
  if (arguments.csv) return printers::CsvText(file, {phases, statistic, arguments.only_sound});
  const bool is_brief = IsBrief(arguments);
  printers::Printed printed =
      printers::Show(file, {arguments.by, arguments.baseline, arguments.only_sound, phases,
                            statistic, arguments.plots, FormatOf(arguments), is_brief});
  if (is_brief && !figures::CountsInstructions(file))
    printed.text += printers::MoreText(file, arguments.file);
  return printed;
}

/// Throws CommandError for options that are about times, which a file that counts instructions has
/// not.
void CheckCounted(const ShowArguments& a) {
  const std::pair<const char*, bool> about_times[] = {{"--phase", !a.phases.empty()},
                                                      {"--stat", !a.statistic.empty()},
                                                      {"--budget", !a.budget.empty()},
                                                      {"--plot", a.plots},
                                                      {"--baseline", !a.baseline.empty()},
                                                      {"--error", !a.error.empty()},
                                                      {"--method", a.method}};
  for (const auto& [name, is_given] : about_times)
    if (is_given)
      throw options::CommandError(fmt::format(
          "{} is about times, and {} has numbers of instructions (`clock instructions`): compare "
          "them with those of another build, cdb compare OTHER.h5 {}",
          name, a.file, terminal::ShellWord(a.file)));
}

options::ExitStatus Show(const ShowArguments& arguments) {
  CheckOptions(arguments);
  results::ResultFile file(arguments.file);
  const bool is_counted = figures::CountsInstructions(file);
  if (is_counted) {
    CheckCounted(arguments);
    file.LeaveOutClock();
  }
  figures::SelectPart(file, arguments.select);
  const printers::Printed shown = PrintedOf(file, arguments);
  (arguments.json ? terminal::PrintJson : terminal::Print)(shown.text);
  if (is_counted) terminal::Say(figures::CountsText(arguments.file));
  return options::StatusOf(shown.bad_count, shown.not_met_count);
}

void DeclareShow(options::Subcommand& command) {
  const auto arguments = std::make_shared<ShowArguments>();
  command.Required("FILE", arguments->file, "results file, or a scenario that was run");
  command.List("--by", arguments->by, "axes of the rows (quantity,detector)");
  command.Baseline(arguments->baseline);
  command.Sound(arguments->only_sound);
  command.Repeated(
      "--select", arguments->select,
      "only these points: AXIS=VALUE, AXIS=A,B or AXIS=A..B; repeat the option for several axes");
  command.List("--phase", arguments->phases, "only these phases (broad,step)");
  command.Optional("--stat", arguments->statistic,
                   "statistic over the cycles: mean (default), median, p5, p95, p99, min, max, or "
                   "worst "
                   "(of any repeat)");
  command.Optional("--table", arguments->table,
                   "one table for a paper, of step, detect, pairs, peak_rss, position, …: a column "
                   "for each detector, and one for its speed-up over --baseline");
  command.Optional("--columns", arguments->columns,
                   "with --table: the axis across (default: detectors, else the last axis)");
  command.Flag("--method", arguments->method,
               "sentences for the section of a paper on its method: machine, software, repeats, "
               "intervals");
  command.Flag("--all", arguments->all,
               "every table and note, not only the conclusions and the times");
  command.Optional("--budget", arguments->budget,
                   "which configurations fit in this time per cycle, such as 4ms (of the step, or "
                   "of --phase)");
  command.Flag("--plot", arguments->plots,
               "also plot, in characters, times over the cycles and over numeric axes");
  command.Optional("--error", arguments->error,
                   "print this error against run time (position, energy, …: cdb doc accuracy)");
  command.List("--each", arguments->each,
               "with --error: a separate table and front for each value of these axes");
  command.Flag("--csv", arguments->csv, "print comma-separated values, one line per point");
  command.Flag("--json", arguments->json,
               "print everything as one JSON document (cdb doc document)");
  command.Flag("--junit", arguments->is_junit,
               "print the requirements of the scenario as JUnit XML (cdb doc requirements)");
  command.Flag("--markdown", arguments->is_markdown, "print the tables in Markdown");
  command.Flag("--latex", arguments->is_latex, "print the tables for LaTeX with booktabs");
  command.Action([arguments] {
    arguments->file = plans::FindResult(arguments->file);
    return Show(*arguments);
  });
}

}  // namespace

options::Command ShowCommand() {
  return {.name = "show",
          .help = "summarise a results file: tables, CSV or JSON",
          .declare = DeclareShow};
}

}  // namespace cdb::cli
