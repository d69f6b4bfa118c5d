#include "runtime/figures/points.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <set>
#include <utility>

#include "compiler/analysis/pruning.h"
#include "compiler/schema/schema.h"
#include "compiler/yaml/brief_runs.h"
#include "compiler/yaml/plan_yaml.h"
#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::figures {
namespace {

bool HasRun(results::Status status) {
  return status != results::Status::kSkipped && status != results::Status::kMissing;
}

/// ` (5 objects, by up to 0.31 of their least side)`; empty if the file does not say.
std::string FrozenText(const results::ResultFile& file, const Cell& cell) {
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

bool IsIn(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

void ReadOmissions(const results::ResultFile& file, MeasuredPoint& point) {
  if (!file.Has("omitted") || !file.Has("needs")) return;
  const std::string omitted = file.ReadText("omitted", point.cells[0]),
                    needs = file.ReadText("needs", point.cells[0]);
  for (const schema::ComponentInfo& info : schema::Components()) {
    if (!info.IsVisible()) continue;
    if (schema::ListsWord(omitted, info.name)) {
      point.left_out.emplace_back(info.name);
    } else if (analysis::SaysKept(needs, info.component)) {
      point.kept.emplace_back(info.name);
    }
  }
}

/// The point without its repeats that have no cycles; nullopt if none has any.
std::optional<MeasuredPoint> ReadPoint(const results::ResultFile& file, const Point& at) {
  MeasuredPoint point{at, {}, "", {}, {}, {}};
  std::vector<Cell> faulty;
  Ending worst;
  for (const Cell& cell : CellsThatRan(file, at)) {
    if (file.ReadCycleCount(cell) == 0) continue;
    if (!Trouble(file, cell)) {
      point.cells.push_back(cell);
      continue;
    }
    worst = WorseOf(worst, EndingOf(file, cell));
    faulty.push_back(cell);
  }
  if (point.cells.empty() && faulty.empty()) return std::nullopt;
  if (point.cells.empty()) {
    point.fault = worst.Word();
    point.cells = std::move(faulty);
  }
  ReadOmissions(file, point);
  return point;
}

}  // namespace

Point Project(const Point& at, const std::vector<std::size_t>& axes) {
  Point part;
  for (const std::size_t axis : axes) part.push_back(at[axis]);
  return part;
}

Point Without(Point at, std::size_t axis) {
  at.erase(at.begin() + static_cast<std::ptrdiff_t>(axis));
  return at;
}

std::vector<Point> AllPoints(const results::ResultFile& file) {
  std::vector<Point> points;
  Point at(file.axes().size(), 0);
  for (;;) {
    points.push_back(at);
    std::size_t i = at.size();
    while (i > 0 && ++at[i - 1] == file.axes()[i - 1].values.size()) at[--i] = 0;
    if (i == 0) return points;
  }
}

std::vector<Cell> AllCells(const results::ResultFile& file) {
  std::vector<Cell> cells;
  for (const Point& at : AllPoints(file))
    for (std::uint64_t rep = 0; rep < file.repeats(); ++rep) cells.push_back({at, rep});
  return cells;
}

std::vector<Cell> CellsThatRan(const results::ResultFile& file, const Point& at) {
  std::vector<Cell> cells;
  for (std::uint64_t rep = 0; rep < file.repeats(); ++rep)
    if (HasRun(file.ReadStatus({at, rep}))) cells.push_back({at, rep});
  return cells;
}

std::string PlaceText(const results::ResultFile& file, const std::vector<std::size_t>& axes,
                      const Point& at) {
  std::string text;
  for (std::size_t i = 0; i < axes.size(); ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", file.axes()[axes[i]].name,
                        terminal::CoordinateText(file.axes()[axes[i]], at[i]));
  return text;
}

std::string PlaceText(const results::ResultFile& file, const Cell& cell) {
  const std::string point = PlaceText(file, AllAxes(file), cell.at);
  return fmt::format("{}{}rep {}", point, point.empty() ? "" : ", ", cell.rep);
}

std::string OnlyCommand(const results::ResultFile& file, const Cell& cell) {
  std::string command =
      fmt::format("cdb run {} -b {} --only {}", terminal::ShellWord(file.source()),
                  file.benchmark(), file.ReadText("run_id", cell));
  const std::string plugins = file.ReadProvenance("plugins");
  return plugins.empty() ? command : command + " " + plugins;
}

std::optional<std::size_t> DetectorAxis(const results::ResultFile& file) {
  const auto axis = std::ranges::find(file.axes(), "detector", &plan::Axis::parameter);
  if (axis == file.axes().end() || !axis->IsText()) return std::nullopt;
  return static_cast<std::size_t>(axis - file.axes().begin());
}

std::size_t FindAxis(const results::ResultFile& file, const std::string& name) {
  std::string names;
  for (std::size_t i = 0; i < file.axes().size(); ++i) {
    if (file.axes()[i].name == name) return i;
    names += (i == 0 ? "" : ", ") + file.axes()[i].name;
  }
  throw files::StoreError(names.empty()
                              ? fmt::format("there is no axis '{}': this file has none", name)
                              : fmt::format("there is no axis '{}'; there are {}", name, names));
}

std::vector<std::size_t> AllAxes(const results::ResultFile& file) {
  std::vector<std::size_t> axes(file.axes().size());
  std::iota(axes.begin(), axes.end(), std::size_t{0});
  return axes;
}

int Ending::Rank() const {
  const int verdict = static_cast<int>(judgement.verdict);
  if (!HasRun(status)) return -1;
  if (status == results::Status::kDone) return verdict;
  // A run without a verdict ended before its first cycle.
  if (judgement.verdict == protocol::Verdict::kUnknown)
    return static_cast<int>(protocol::Verdict::kCrashed) + 1;
  return std::max(verdict, static_cast<int>(protocol::Verdict::kTimedOut));
}

std::string Ending::Word() const {
  return std::string(status == results::Status::kDone ? protocol::VerdictName(judgement.verdict)
                                                      : results::StatusName(status));
}

bool Ending::IsKnown() const {
  return HasRun(status) &&
         (status != results::Status::kDone || judgement.verdict != protocol::Verdict::kUnknown);
}

Ending WorseOf(const Ending& one, const Ending& other) {
  if (one.Rank() != other.Rank()) return one.Rank() > other.Rank() ? one : other;
  const std::int64_t of_one = one.judgement.first_bad_cycle,
                     of_other = other.judgement.first_bad_cycle;
  return of_other >= 0 && (of_one < 0 || of_other < of_one) ? other : one;
}

Ending EndingOf(const results::ResultFile& file, const Cell& cell) {
  return {file.ReadStatus(cell), file.ReadJudgement(cell)};
}

Ending WorstEnding(const results::ResultFile& file, const Point& at) {
  Ending worst = EndingOf(file, {at, 0});
  for (std::uint64_t rep = 1; rep < file.repeats(); ++rep)
    worst = WorseOf(worst, EndingOf(file, {at, rep}));
  return worst;
}

std::optional<std::string> Trouble(const results::ResultFile& file, const Cell& cell) {
  const results::Status status = file.ReadStatus(cell);
  if (status == results::Status::kMissing) return "not run yet";
  if (status != results::Status::kDone) {
    const std::string message = file.ReadText("message", cell);
    return std::string(results::StatusName(status)) + (message.empty() ? "" : ": ") + message;
  }
  const protocol::Judgement judgement = file.ReadJudgement(cell);
  if (!protocol::HasVoidTimings(judgement.verdict)) return std::nullopt;
  return fmt::format("{} from cycle {} on{}", protocol::VerdictName(judgement.verdict),
                     judgement.first_bad_cycle,
                     judgement.verdict == protocol::Verdict::kFrozen ? FrozenText(file, cell) : "");
}

std::string MeasuredPoint::Mark() const {
  const std::string without =
      unlike.empty() ? "" : fmt::format("without {}", fmt::join(unlike, ", "));
  return fault + (fault.empty() || without.empty() ? "" : ", ") + without;
}

std::vector<std::string> MeasuredPoint::UnlikeComponents(const MeasuredPoint& other) const {
  std::vector<std::string> components;
  for (const std::string& name : left_out)
    if (IsIn(other.kept, name)) components.push_back(name);
  for (const std::string& name : other.left_out)
    if (IsIn(kept, name)) components.push_back(name);
  return components;
}

std::vector<MeasuredPoint> MeasuredPoints(const results::ResultFile& file, bool only_sound) {
  std::vector<MeasuredPoint> points;
  std::set<std::string> kept_somewhere;
  for (const Point& at : AllPoints(file)) {
    auto point = ReadPoint(file, at);
    if (!point || (only_sound && !point->IsSound())) continue;
    kept_somewhere.insert(point->kept.begin(), point->kept.end());
    points.push_back(*std::move(point));
  }
  for (MeasuredPoint& point : points)
    std::ranges::copy_if(point.left_out, std::back_inserter(point.unlike),
                         [&](const std::string& name) { return kept_somewhere.contains(name); });
  return points;
}

CellGroups GroupCells(const results::ResultFile& file) {
  CellGroups groups;
  for (const Cell& cell : AllCells(file)) {
    const results::Status status = file.ReadStatus(cell);
    if (status == results::Status::kSkipped) {
      ++groups.skipped;
    } else if (status == results::Status::kMissing) {
      ++groups.missing;
    } else if (const auto trouble = Trouble(file, cell)) {
      groups.bad.push_back({cell, *trouble});
    } else {
      const protocol::Judgement judgement = file.ReadJudgement(cell);
      groups.good.push_back(cell);
      groups.verdicts[judgement.verdict].push_back({cell, judgement.first_bad_cycle});
    }
  }
  return groups;
}

std::optional<plan::Plan> ReadPlan(const results::ResultFile& file) {
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

CellDetectors::CellDetectors(const results::ResultFile& file)
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

}  // namespace cdb::figures
