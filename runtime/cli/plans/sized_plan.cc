#include "runtime/cli/plans/sized_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <system_error>
#include <utility>

#include "compiler/analysis/reference.h"
#include "compiler/compile.h"
#include "compiler/grid/part.h"
#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
#include "runtime/cli/options/subcommand.h"
#include "runtime/figures/points.h"
#include "runtime/printers/show.h"
#include "runtime/results/store.h"
#include "runtime/sweep/schedule/folder.h"
#include "runtime/terminal/console.h"

namespace cdb::plans {
namespace {

using Files = std::map<std::string, std::string>;

/// A reader that records the scenario files it reads.
scenario::ReadFile NoteFiles(Files& files) {
  return [&files](const std::string& path, std::string& why) {
    auto text = options::ReadInput(path, why);
    // Plug-ins are only read for their hash.
    if (text && (path.ends_with(".cdb") || path == options::kStandardInput)) files[path] = *text;
    return text;
  };
}

/// `form`: the known members; its hash and number of runs are filled in.
std::string ShortText(yaml::ShortPlan form, const plan::Plan& head, const std::string& sha256,
                      std::uint64_t runs) {
  form.benchmark = head.benchmark;
  form.source = head.source;
  form.sha256 = sha256;
  form.runs = runs;
  return yaml::ToYaml(form);
}

SizedPlan MakeLong(grid::Grid made, const yaml::ShortPlan& form) {
  SizedPlan sized;
  sized.grid = std::make_shared<const grid::Grid>(std::move(made));
  auto whole = std::make_shared<plan::WholePlan>(grid::MakeWhole(sized.grid));
  if (std::ranges::any_of(whole->bounds,
                          [](const plan::Run& run) { return analysis::NeedsReference(run.scene); }))
    throw options::CommandError(
        fmt::format("{}: {} runs are too many for reference runs, which need a plan of at most {}; "
                    "split the benchmark, or remove `accuracy`",
                    sized.grid->head.benchmark, whole->run_count, compiler::kMostListed));
  whole->short_text = ShortText(form, sized.grid->head, whole->sha256, whole->run_count);
  sized.short_text = whole->short_text;
  sized.plan = sized.grid->head;
  sized.plan.whole = std::move(whole);
  return sized;
}

/// Lists the runs unless there are too many.
SizedPlan Make(grid::Grid made, const yaml::ShortPlan& form) {
  if (made.run_count() > compiler::kMostListed) return MakeLong(std::move(made), form);
  SizedPlan sized = {grid::ListRuns(made), nullptr, {}};
  sized.short_text = ShortText(form, sized.plan, sized.plan.Sha256(), sized.plan.runs.size());
  return sized;
}

SizedPlan Expand(const yaml::ShortPlan& form, const std::string& name) {
  const auto read = [&form](const std::string& path,
                            std::string& why) -> std::optional<std::string> {
    const auto found = form.files.find(path);
    if (found != form.files.end()) return found->second;
    return path.ends_with(".cdb") ? std::nullopt : compiler::ReadFromDisk(path, why);
  };
  compiler::Compilation made = compiler::Compile(
      form.file, read, options::OptionsOf(form.library, form.benchmark, form.plugins, false));
  if (!made.diagnostics.has_errors() && made.grids.size() == 1) {
    made.grids[0].head.source = form.source;
    SizedPlan sized = Make(std::move(made.grids[0]), form);
    if (sized.plan.Sha256() == form.sha256) return sized;
  }
  throw options::CommandError(
      fmt::format("{}: this cdb, or its plug-ins, make another plan of it; use the cdb that wrote "
                  "it, or plan again from '{}'",
                  name, form.source));
}

}  // namespace

plan::Plan SizedPlan::ListPart(std::uint64_t index, std::uint64_t count) const {
  return grid::ListPart(*grid, plan.whole, {index, count});
}

SizedPlan ReadSizedPlan(const std::string& text, const std::string& name) {
  if (const auto form = yaml::FindShortPlan(text, name)) return Expand(*form, name);
  return {yaml::FromYaml(text, name), nullptr, {}};
}

std::string FindPlanIn(const std::filesystem::path& folder) {
  std::error_code error;
  for (const char* name : {schedule::kShortPlanName, schedule::kPlanName})
    if (std::filesystem::exists(folder / name, error)) return (folder / name).string();
  return {};
}

SizedPlan ReadPlanFile(const std::string& file, const std::string& text) {
  const std::filesystem::path list =
      std::filesystem::path(file).parent_path() / schedule::kPlanName;
  std::error_code error;
  if (!file.ends_with(schedule::kShortPlanName) || !std::filesystem::exists(list, error))
    return ReadSizedPlan(text, file);
  try {
    return ReadSizedPlan(text, file);
  } catch (const options::CommandError&) {
    return ReadSizedPlan(options::ReadText(list.string()), list.string());
  }
}

std::vector<SizedPlan> LoadSizedPlans(const std::string& file,
                                      const std::optional<std::string>& benchmark,
                                      options::LintText lints,
                                      const std::vector<std::string>& plugins) {
  std::vector<SizedPlan> all;
  if (options::IsPlanFile(file)) {
    const auto form = yaml::FindShortPlan(options::ReadText(file), file);
    if (!form) {
      for (plan::Plan& plan : options::LoadPlans(file, benchmark, lints, plugins))
        all.push_back({std::move(plan), nullptr, {}});
      return all;
    }
    options::CheckPlanFile(file, benchmark, plugins, form->benchmark);
    all.push_back(Expand(*form, file));
    return all;
  }
  Files files;
  auto grids = options::LoadGrids(file, benchmark, lints, plugins, NoteFiles(files));
  if (grids.empty()) return all;
  yaml::ShortPlan form;
  form.file = options::FindScenario(file);
  form.library = options::ScenarioLibrary();
  form.plugins = plugins;
  form.files = files;
  for (grid::Grid& grid : grids) all.push_back(Make(std::move(grid), form));
  return all;
}

namespace fs = std::filesystem;

options::ExitStatus ShowResult(const fs::path& out, bool is_quiet) {
  printers::ShowOptions options;
  options.is_brief = true;
  results::ResultFile file(out, results::ProofOf::kStructure);
  const bool is_counted = figures::CountsInstructions(file);
  if (is_counted) file.LeaveOutClock();
  const printers::Printed shown = printers::Show(file, options);
  if (!is_quiet) {
    terminal::Print(fmt::format(
        "{}{}\n{}\n", shown.text,
        is_counted ? figures::CountsText(out.string()) : printers::MoreText(file, out.string()),
        out.string()));
  } else {
    const auto say = [&](std::size_t count, const char* what) {
      if (count > 0)
        terminal::Say(
            fmt::format("{}: `cdb show {}` names them\n", what, terminal::ShellWord(out.string())));
    };
    say(shown.bad_count, "some runs did not end well, or missed pairs");
    say(shown.not_met_count, "requirements are not met");
  }
  return options::StatusOf(shown.bad_count, shown.not_met_count);
}

}  // namespace cdb::plans
