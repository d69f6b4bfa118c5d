// `cdb plan`: prints the runs of a scenario as a table or as YAML, or the omissions of each run.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/pruning.h"
#include "compiler/plan/plan.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/layouts/initial_state.h"
#include "library/scene_error.h"
#include "runtime/cli/options/inputs.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/cli/plans/sweep_estimate.h"
#include "runtime/omissions/omissions.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/sweep/process/stop.h"
#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::cli {
namespace {

struct PlanArguments {
  std::string file;
  std::optional<std::string> benchmark;
  std::string out;                    ///< empty: a table on standard output; `-`: YAML there
  bool why = false;                   ///< explain the omissions of each run, in place of the table
  std::string only;                   ///< the id of the one run that `why` explains, or empty
  bool estimate = false;              ///< estimate the cost of the sweep, in place of the table
  std::uint64_t jobs = 1;             ///< runs at a time, for the estimate
  std::vector<std::string> plugins;   ///< shared libraries with detectors
  std::vector<std::string> settings;  ///< NAME=VALUE, over those of the scenario
};

/// The components that a run omits; `?` after a name if the placed objects decide.
std::string LeftOut(const plan::Scene& scene) {
  using analysis::Decision;
  std::string names;
  for (const analysis::PruningDecision& part : analysis::AnalysePruning(scene)) {
    const schema::ComponentInfo& info = InfoOf(part.component);
    if (!info.IsVisible() ||
        (part.decision != Decision::kLeftOut && part.decision != Decision::kOpen))
      continue;
    names += fmt::format("{}{}{}", names.empty() ? "" : " ", info.name,
                         part.decision == Decision::kOpen ? "?" : "");
  }
  return names.empty() ? "-" : names;
}

/// `walls: left out: …` for each component, in columns.
std::string InColumns(std::string_view decisions) {
  std::size_t widest = 0;
  for (const schema::ComponentInfo& info : schema::Components())
    widest = std::max(widest, info.name.size());
  std::string text;
  while (!decisions.empty()) {
    const std::string_view line = decisions.substr(0, decisions.find('\n'));
    decisions.remove_prefix(std::min(decisions.size(), line.size() + 1));
    const std::size_t name = line.find(": "), decision = line.find(": ", name + 2);
    text += fmt::format("  {:{}}  {:8}  {}\n", line.substr(0, name), widest,
                        line.substr(name + 2, decision - name - 2), line.substr(decision + 2));
  }
  return text;
}

/// False if the scene cannot be made, or needs a component that `omit` names.
bool SayWhy(const plan::Scene& scene) {
  try {
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    terminal::Print(InColumns(DecisionsText(omissions::DecideOmissions(scene, state).decisions)));
    return true;
  } catch (const library::SceneError& error) {
    terminal::Print(fmt::format("  this run fails: {}\n", error.what()));
    return false;
  }
}

options::ExitStatus Why(const std::vector<plan::Plan>& plans, const std::string& only) {
  bool good = true, found = false;
  for (const plan::Plan& plan : plans) {
    const std::vector<std::size_t>* last = nullptr;
    for (const plan::Run& run : plan.runs) {
      if (!only.empty() && run.id != only) continue;
      // Repeats have the same scene.
      if (last != nullptr && run.at == *last) continue;
      last = &run.at;
      const std::string alike = only.empty() && plan.repeats > 1
                                    ? fmt::format(" and {} more like it", plan.repeats - 1)
                                    : std::string();
      terminal::Print(fmt::format("{}{}  {}: {}{}\n", found ? "\n" : "", run.id, plan.benchmark,
                                  plan::Describe(plan, run), alike));
      good = SayWhy(run.scene) && good;
      terminal::Flush();
      found = true;
    }
  }
  if (!found)
    throw options::CommandError(
        fmt::format("no run has the id '{}'; `cdb plan` lists the ids", only));
  return good ? options::ExitStatus::kGood : options::ExitStatus::kScenarioError;
}

/// Limit of runs in a table; a plan in YAML has them all.
constexpr std::uint64_t kMostShown = 10'000;

/// `plan`: holds the runs to show, out of `runs`; `skipped` points have none.
std::string PlanTable(const plan::Plan& plan, std::uint64_t runs, double skipped) {
  const std::string grid = terminal::GridText(plan.axes, plan.repeats);
  std::string text = fmt::format("{}: {} {}{}{}\n", plan.benchmark, runs,
                                 runs == 1 ? "run" : "runs", grid.empty() ? "" : " = " + grid,
                                 skipped > 0 ? fmt::format(", {:.0f} skipped", skipped) : "");
  if (!plan.references.empty())
    text += fmt::format(
        "  compared with {}, checked by a twin with another time step: cdb doc accuracy\n",
        plan.references.size() == 2
            ? "a reference run"
            : fmt::format("{} reference runs, each", plan.references.size() / 2));
  terminal::Table table;
  table.AddColumn("run", false);
  for (const plan::Axis& axis : plan.axes) table.AddColumn(axis.name, !axis.IsText());
  if (plan.repeats > 1) table.AddColumn("rep", true);
  table.AddColumn("objects", true);
  table.AddColumn("side", true);
  table.AddColumn("cycles", true);
  table.AddColumn("left out", false);
  bool has_open = false;
  std::vector<std::vector<std::string>> labels;
  for (const plan::Axis& axis : plan.axes) labels.push_back(plan::CoordinateLabels(axis));
  for (const plan::Run& run : plan.runs) {
    std::vector<std::string> row = {run.id};
    for (std::size_t i = 0; i < plan.axes.size(); ++i) row.push_back(labels[i][run.at[i]]);
    if (plan.repeats > 1) row.push_back(fmt::format("{}", run.rep));
    row.push_back(fmt::format("{}", run.scene.ObjectCount()));
    row.push_back(plan::ShortReal(run.scene.world.Real("world.side")));
    row.push_back(fmt::format("{}", run.scene.world.Count("cycles")));
    row.push_back(LeftOut(run.scene));
    has_open = has_open || row.back().find('?') != std::string::npos;
    table.AddRow(std::move(row));
  }
  text += table.Text();
  if (has_open)
    text += fmt::format("?: the positions of the objects decide; `cdb plan --why {}` places them\n",
                        terminal::ShellWord(plan.source));
  if (plan.runs.size() < runs)
    text += fmt::format("and {} more; `cdb plan -o PLAN.yaml {}` writes all\n",
                        runs - plan.runs.size(), terminal::ShellWord(plan.source));
  return text;
}

std::string PlanTable(const grid::Grid& grid) {
  const std::uint64_t most = std::max<std::uint64_t>(1, kMostShown / grid.head.repeats);
  return PlanTable(grid::ListRuns(grid, most), grid.run_count(),
                   grid::CountOf(grid.extents()) - static_cast<double>(grid.point_count));
}

void PrintTables(const std::vector<std::string>& tables) {
  for (std::size_t i = 0; i < tables.size(); ++i) terminal::Print((i > 0 ? "\n" : "") + tables[i]);
}

/// Writes one run after the other.
template <typename Write>
void WritePlan(const std::string& out, Write write) {
  if (out == "-") {
    write([](std::string_view piece) { terminal::PrintExact(piece); });
  } else {
    files::WritePieces(write, out);
  }
}

void RequireOne(std::size_t benchmarks, const std::string& file) {
  if (benchmarks > 1)
    throw options::CommandError(
        fmt::format("{} has {} benchmarks, but a plan has one: choose it by -b", file, benchmarks));
}

/// Prints a plan that was written before.
options::ExitStatus PrintPlanFile(const PlanArguments& arguments) {
  const auto plans = options::LoadPlans(arguments.file, arguments.benchmark,
                                        options::LintText::kOneLine, arguments.plugins);
  const plan::Plan& plan = plans.at(0);
  if (arguments.out.empty()) {
    PrintTables({PlanTable(plan, plan.runs.size(), static_cast<double>(plan.skipped.size()))});
  } else {
    WritePlan(arguments.out, [&](const auto& write) { write(yaml::ToYaml(plan)); });
  }
  return options::ExitStatus::kGood;
}

options::ExitStatus PrintEstimates(const PlanArguments& arguments) {
  if (arguments.why || !arguments.out.empty())
    throw options::CommandError("--estimate cannot be combined with --why or -o");
  if (options::IsPlanFile(arguments.file))
    throw options::CommandError(
        fmt::format("--estimate takes a scenario file, but {} is a plan", arguments.file));
  const auto grids = options::LoadGrids(arguments.file, arguments.benchmark,
                                        options::LintText::kOneLine, arguments.plugins);
  process::StopFlag stop;
  const process::StopOnSignals signals(stop);
  for (const grid::Grid& grid : grids) {
    const plans::SweepEstimate estimate = plans::EstimateSweep(grid, stop);
    if (stop.requested()) return options::StoppedBy(stop.signal());
    terminal::Print(plans::EstimateText(estimate, grid.head.benchmark, arguments.jobs));
  }
  return grids.empty() ? options::ExitStatus::kScenarioError : options::ExitStatus::kGood;
}

options::ExitStatus PrintPlans(const PlanArguments& arguments) {
  if (arguments.estimate) return PrintEstimates(arguments);
  if (arguments.why && !arguments.out.empty())
    throw options::CommandError("--why cannot be combined with -o");
  if (!arguments.why && !arguments.only.empty())
    throw options::CommandError(
        "--only is an option of `cdb plan --why` and of `cdb run`; a plan has all runs");
  const std::string file = options::FileOrStandardInput(arguments.file);
  if (arguments.why) {
    const auto plans = options::LoadPlans(file, arguments.benchmark, options::LintText::kOneLine,
                                          arguments.plugins);
    return plans.empty() ? options::ExitStatus::kScenarioError : Why(plans, arguments.only);
  }
  if (options::IsPlanFile(arguments.file)) return PrintPlanFile(arguments);
  const auto grids =
      options::LoadGrids(file, arguments.benchmark, options::LintText::kOneLine, arguments.plugins);
  if (grids.empty()) return options::ExitStatus::kScenarioError;
  if (arguments.out.empty()) {
    std::vector<std::string> tables;
    for (const grid::Grid& grid : grids) tables.push_back(PlanTable(grid));
    PrintTables(tables);
    return options::ExitStatus::kGood;
  }
  RequireOne(grids.size(), arguments.file);
  WritePlan(arguments.out, [&](const auto& write) { grid::WriteYaml(grids[0], write); });
  return options::ExitStatus::kGood;
}

void DeclarePlan(options::Subcommand& command) {
  const auto arguments = std::make_shared<PlanArguments>();
  command.Required("FILE", arguments->file, "scenario file (- for standard input), or a plan");
  command.Benchmark(arguments->benchmark);
  command.Out(arguments->out, "write the plan as YAML; - for standard output");
  command.Flag("--why", arguments->why, "place the objects of each run, and explain each omission");
  command.Optional("--only", arguments->only, "with --why: only this run");
  command.Flag("--estimate", arguments->estimate,
               "execute a few runs for a few cycles, and estimate the cost of all runs");
  command.Jobs(arguments->jobs, "with --estimate: number of parallel runs (default: 1)");
  command.Plugins(arguments->plugins);
  command.Set(arguments->settings);
  command.Action([arguments] {
    options::SetInScenario(arguments->file, arguments->benchmark, arguments->settings);
    return PrintPlans(*arguments);
  });
}

}  // namespace

options::Command PlanCommand() {
  return {
      .name = "plan", .help = "print the expanded runs of a scenario file", .declare = DeclarePlan};
}

}  // namespace cdb::cli
