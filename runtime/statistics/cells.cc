#include "runtime/statistics/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compiler/yaml/brief_runs.h"
#include "compiler/yaml/plan_yaml.h"
#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::statistics {

using Cell = store::ResultFile::Cell;

std::vector<Cell> AllCells(const store::ResultFile& file) {
  std::vector<Cell> cells;
  std::vector<std::size_t> at(file.axes().size(), 0);
  for (;;) {
    for (std::uint64_t rep = 0; rep < file.repeats(); ++rep) cells.push_back({at, rep});
    std::size_t i = at.size();
    while (i > 0 && ++at[i - 1] == file.axes()[i - 1].values.size()) at[--i] = 0;
    if (i == 0) return cells;
  }
}

std::string PlaceText(const store::ResultFile& file, const Cell& cell) {
  std::string text;
  for (std::size_t i = 0; i < cell.at.size(); ++i)
    text += fmt::format("{} {}, ", file.axes()[i].name,
                        terminal::CoordinateText(file.axes()[i], cell.at[i]));
  return text + fmt::format("rep {}", cell.rep);
}

std::string OnlyCommand(const store::ResultFile& file, const Cell& cell) {
  std::string command =
      fmt::format("cdb run {} -b {} --only {}", terminal::ShellWord(file.source()),
                  file.benchmark(), file.ReadText("run_id", cell));
  const std::string plugins = file.ReadProvenance("plugins");
  return plugins.empty() ? command : command + " " + plugins;
}

std::optional<std::size_t> DetectorAxis(const store::ResultFile& file) {
  const auto axis = std::ranges::find(file.axes(), "detector", &plan::Axis::parameter);
  if (axis == file.axes().end() || !axis->IsText()) return std::nullopt;
  return static_cast<std::size_t>(axis - file.axes().begin());
}

PointVerdict WorstVerdict(const store::ResultFile& file, const std::vector<std::size_t>& at) {
  std::optional<measure::Judgement> worst;
  for (std::uint64_t rep = 0; rep < file.repeats(); ++rep) {
    const store::Status status = file.ReadStatus({at, rep});
    const measure::Judgement judgement = file.ReadJudgement({at, rep});
    if (judgement.verdict == measure::Verdict::kUnknown && status != store::Status::kDone)
      return {std::string(store::StatusName(status))};
    if (!worst || judgement.verdict > worst->verdict ||
        (judgement.verdict == worst->verdict && judgement.first_bad_cycle < worst->first_bad_cycle))
      worst = judgement;
  }
  return {std::string(measure::VerdictName(worst->verdict)), worst->first_bad_cycle};
}

std::optional<plan::Plan> ReadPlan(const store::ResultFile& file) {
  thread_local std::optional<plan::Plan> last;
  thread_local std::string last_sha256;
  if (!last || last_sha256 != file.plan_sha256()) {
    try {
      last = yaml::FromYaml(file.ReadProvenance("plan_text"), "the plan of the results");
    } catch (const yaml::PlanError&) {
      return std::nullopt;
    }
    last_sha256 = file.plan_sha256();
  }
  plan::Plan plan = *last;
  std::erase_if(plan.runs, [&](plan::Run& run) {
    auto at = file.SelectedPoint(run.at);
    if (at) run.at = *std::move(at);
    return !at;
  });
  return plan;
}

CellDetectors::CellDetectors(const store::ResultFile& file)
    : file_(file), axis_(DetectorAxis(file)) {
  if (axis_) return;
  const auto runs = yaml::FindBriefRuns(file.ReadProvenance("plan_text"));
  if (!runs) return;
  for (const yaml::BriefRun& run : *runs) by_run_.emplace(run.id, run.detector);
}

std::string CellDetectors::Of(const Cell& cell) const {
  if (axis_) return terminal::CoordinateText(file_.axes()[*axis_], cell.at[*axis_]);
  const auto found = by_run_.find(file_.ReadText("run_id", cell));
  return found == by_run_.end() ? "" : found->second;
}

std::size_t FindAxis(const store::ResultFile& file, const std::string& name) {
  std::string names;
  for (std::size_t i = 0; i < file.axes().size(); ++i) {
    if (file.axes()[i].name == name) return i;
    names += (i == 0 ? "" : ", ") + file.axes()[i].name;
  }
  throw files::StoreError(names.empty()
                              ? fmt::format("there is no axis '{}': this file has none", name)
                              : fmt::format("there is no axis '{}'; there are {}", name, names));
}

namespace {

/// ` (5 objects, by up to 0.31 of their least side)`; empty if the file does not say.
std::string FrozenText(const store::ResultFile& file, const Cell& cell) {
  if (!file.Has("frozen") || !file.Has("lost_way")) return {};
  const auto most = [&](const char* series) {
    double largest = 0;
    for (const double value : file.ReadSeries(series, cell)) largest = std::fmax(largest, value);
    return largest;
  };
  const double objects = most("frozen");
  return fmt::format(" ({} object{}, by up to {} of the least side)", objects,
                     objects == 1 ? "" : "s", terminal::ShortNumber(most("lost_way")));
}

}  // namespace

std::optional<std::string> Trouble(const store::ResultFile& file, const Cell& cell) {
  const store::Status status = file.ReadStatus(cell);
  if (status == store::Status::kMissing) return "not run yet";
  if (status != store::Status::kDone) {
    const std::string message = file.ReadText("message", cell);
    return std::string(store::StatusName(status)) + (message.empty() ? "" : ": ") + message;
  }
  const measure::Judgement judgement = file.ReadJudgement(cell);
  if (!measure::HasVoidTimings(judgement.verdict)) return std::nullopt;
  return fmt::format("{} from cycle {} on{}", measure::VerdictName(judgement.verdict),
                     judgement.first_bad_cycle,
                     judgement.verdict == measure::Verdict::kFrozen ? FrozenText(file, cell) : "");
}

std::string FaultOf(const store::ResultFile& file, const Cell& cell) {
  const store::Status status = file.ReadStatus(cell);
  return std::string(status == store::Status::kDone
                         ? measure::VerdictName(file.ReadJudgement(cell).verdict)
                         : store::StatusName(status));
}

}  // namespace cdb::statistics
