#include "runtime/figures/points.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "compiler/analysis/pruning.h"
#include "compiler/plan/clock.h"
#include "compiler/plan/plan.h"
#include "compiler/schema/schema.h"
#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
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
  // They are written as options.
  for (const char* fact : {"settings", "plugins"})
    if (const std::string options = file.ReadProvenance(fact); !options.empty())
      command += " " + options;
  return command;
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
  throw files::StoreError(
      names.empty() ? fmt::format("there is no axis '{}': this file has none, only one point", name)
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

bool IsNoisy(const results::ResultFile& file, const Cell& cell) {
  return file.Has("noise") &&
         file.ReadReal("noise", cell) == static_cast<double>(machine::Noise::kNoisy);
}

std::size_t CountNoisy(const results::ResultFile& file, const std::vector<Cell>& cells) {
  return static_cast<std::size_t>(
      std::ranges::count_if(cells, [&](const Cell& cell) { return IsNoisy(file, cell); }));
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

bool CountsInstructions(const results::ResultFile& file) {
  const std::optional<plan::Plan> plan = ReadPlan(file);
  return plan && plan::CountsInstructions(*plan);
}

bool HasCounters(const results::ResultFile& file) { return file.Has("counters"); }

std::string CountsText(const std::string& name) {
  return fmt::format(
      "Left out: the numbers of instructions, which are no times; with those of another build: cdb "
      "compare OTHER.h5 {}\n",
      terminal::ShellWord(name));
}

void RequireTimes(const results::ResultFile& file, const std::string& name) {
  if (CountsInstructions(file))
    throw files::StoreError(
        fmt::format("{0} has numbers of instructions, not times (`clock instructions`): compare it "
                    "with that of another build, cdb compare OTHER.h5 {0}",
                    name));
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
  for (const yaml::BriefRun& run : *runs)
    by_run_.emplace(run.id,
                    run.is_on_trace && run.narrow_phase != "own" ? run.narrow_phase : run.detector);
}

std::string CellDetectors::Of(const Cell& cell) const {
  if (axis_) return terminal::CoordinateText(file_.axes()[*axis_], cell.at[*axis_]);
  const auto found = by_run_.find(file_.ReadText("run_id", cell));
  return found == by_run_.end() ? "" : found->second;
}

namespace {

/// The coordinates of the point on the axes that make no rows.
Point RestOf(const MeasuredPoint& point, const std::vector<std::size_t>& by) {
  Point rest;
  for (std::size_t i = 0; i < point.at.size(); ++i)
    if (std::ranges::find(by, i) == by.end()) rest.push_back(point.at[i]);
  return rest;
}

/// Drops the points that some of `rows`, which are of one kind, lack. False if none would remain.
bool Match(const std::vector<Row*>& rows, const std::vector<std::size_t>& by) {
  std::map<Point, std::size_t> counts;
  for (const Row* row : rows)
    for (const MeasuredPoint* point : row->points) ++counts[RestOf(*point, by)];
  std::erase_if(counts, [&](const auto& cell) { return cell.second < rows.size(); });
  if (counts.empty()) return false;
  for (Row* row : rows)
    std::erase_if(row->points,
                  [&](const MeasuredPoint* point) { return !counts.contains(RestOf(*point, by)); });
  return true;
}

}  // namespace

std::string Row::CellsText() const {
  return points.size() == own ? fmt::format("{}", own)
                              : fmt::format("{} of {}", points.size(), own);
}

std::vector<std::string> Rows::MatchNotes() const {
  std::vector<std::string> notes;
  if (!pools) return notes;
  if (std::ranges::any_of(rows, [](const Row& row) { return row.points.size() < row.own; }))
    notes.emplace_back("A row pools only the cells that all rows of its kind have: k of its n.");
  if (is_unmatched)
    notes.emplace_back(
        "No cell is in all rows of a kind, so each row has different cells: do not compare them.");
  return notes;
}

Rows MatchRows(const std::vector<const MeasuredPoint*>& points, std::vector<std::size_t> by) {
  std::map<std::tuple<Point, bool, std::string>, Row> found;
  for (const MeasuredPoint* point : points) {
    const Point at = Project(point->at, by);
    Row& row = found[{at, !point->IsSound(), point->Mark()}];
    row.at = at;
    row.mark = point->Mark();
    row.is_void = !point->IsSound();
    row.points.push_back(point);
  }
  Rows all;
  std::map<std::string, std::vector<Row*>> kinds;
  for (auto& [key, row] : found) {
    row.own = row.points.size();
    all.pools = all.pools || row.own > 1;
    kinds[row.mark].push_back(&row);
  }
  for (const auto& [mark, rows] : kinds)
    if (!Match(rows, by)) all.is_unmatched = true;
  all.pools = all.pools || all.is_unmatched;
  for (auto& [key, row] : found) all.rows.push_back(std::move(row));
  all.by = std::move(by);
  return all;
}

Rows MatchRows(const std::vector<MeasuredPoint>& points, std::vector<std::size_t> by) {
  std::vector<const MeasuredPoint*> all;
  for (const MeasuredPoint& point : points) all.push_back(&point);
  return MatchRows(all, std::move(by));
}

namespace {

/// Relative tolerances: of two spellings of one value, and of a value with the digits of a table.
constexpr double kSame = 1e-9, kShown = 1e-4;

/// Nullopt if the whole text is not a number.
std::optional<double> NumberIn(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::set<std::size_t> FindNumbers(const plan::Axis& axis, const std::string& text) {
  std::set<std::size_t> found;
  const auto dots = text.find("..");
  const auto from = NumberIn(std::string_view(text).substr(0, dots));
  const auto to = dots == text.npos ? from : NumberIn(std::string_view(text).substr(dots + 2));
  if (!from || !to) return found;
  std::optional<std::size_t> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < axis.values.size(); ++i) {
    const double value = std::get<double>(axis.values[i]), slack = kSame * std::fabs(value);
    if (value >= *from - slack && value <= *to + slack) found.insert(i);
    const double distance = std::fabs(value - *from);
    if (distance > kShown * std::fabs(value) || distance >= least) continue;
    least = distance;
    nearest = i;
  }
  if (found.empty() && dots == text.npos && nearest) found.insert(*nearest);
  return found;
}

std::set<std::size_t> FindValue(const plan::Axis& axis, const std::vector<std::string>& labels,
                                const std::string& text) {
  const auto found = std::ranges::find(labels, text);
  if (found != labels.end()) return {static_cast<std::size_t>(found - labels.begin())};
  return axis.IsText() ? std::set<std::size_t>() : FindNumbers(axis, text);
}

}  // namespace

AxisSelection ParseSelection(const std::string& word) {
  const std::size_t equals = word.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
    throw files::StoreError(
        fmt::format("'{}' selects nothing; write AXIS=VALUE, such as detector=dbvt", word));
  return {word.substr(0, equals), word.substr(equals + 1)};
}

NamedValues FindValues(const plan::Axis& axis, const std::string& text) {
  const std::vector<std::string> labels = plan::CoordinateLabels(axis);
  // A label may contain a comma.
  std::set<std::size_t> found = FindValue(axis, labels, text);
  NamedValues values;
  for (std::size_t begin = 0; found.empty() && begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::set<std::size_t> here = FindValue(axis, labels, part);
    values.indices.insert(values.indices.end(), here.begin(), here.end());
    if (here.empty()) values.unknown.push_back(part);
    begin = end + 1;
  }
  found.insert(values.indices.begin(), values.indices.end());
  values.indices.assign(found.begin(), found.end());
  return values;
}

std::string ValuesText(const plan::Axis& axis, const std::vector<std::size_t>& indices) {
  const std::vector<std::string> labels = plan::CoordinateLabels(axis);
  std::vector<std::string> values;
  for (const std::size_t i : indices) values.push_back(labels[i]);
  return fmt::format("{}", fmt::join(values, ", "));
}

std::string ValuesText(const plan::Axis& axis) {
  return fmt::format("{}", fmt::join(plan::CoordinateLabels(axis), ", "));
}

void SelectPart(results::ResultFile& file, const std::vector<std::string>& selections) {
  std::set<std::string> seen;
  for (const std::string& word : selections) {
    const auto [name, text] = ParseSelection(word);
    const std::size_t at = FindAxis(file, name);
    if (!seen.insert(name).second)
      throw files::StoreError(fmt::format(
          "--select names the axis '{}' twice: list its values in one, as {}=A,B", name, name));
    const plan::Axis& axis = file.axes()[at];
    const NamedValues values = FindValues(axis, text);
    if (!values.unknown.empty())
      throw files::StoreError(fmt::format("the axis '{}' has no value {}; it has {}", name,
                                          values.unknown[0].empty() ? "''" : values.unknown[0],
                                          ValuesText(axis)));
    file.Select(at, values.indices);
  }
}

namespace {

/// True if the scenes simulated in two runs differ, whatever the methods.
bool AreDifferentScenes(const plan::Scene& one, const plan::Scene& other) {
  if (one.groups.size() != other.groups.size() || one.joints != other.joints ||
      one.queries.size() != other.queries.size())
    return true;
  const auto differ = [](const plan::Settings& a, const plan::Settings& b,
                         const schema::Parameter& parameter) {
    return (a.Has(parameter) || b.Has(parameter)) && a.ValueOf(parameter) != b.ValueOf(parameter);
  };
  return std::ranges::any_of(schema::Schema(), [&](const schema::Parameter& parameter) {
    if (parameter.concern != schema::Concern::kScene) return false;
    if (!parameter.grouped) return differ(one.world, other.world, parameter);
    const auto any_differs = [&](const auto& a, const auto& b) {
      for (std::size_t i = 0; i < a.size(); ++i)
        if (differ(a[i].settings, b[i].settings, parameter)) return true;
      return false;
    };
    return any_differs(one.groups, other.groups) || any_differs(one.queries, other.queries);
  });
}

/// True if the scene depends on an axis that is no parameter: a `let`, or `cases`.
bool ChangesScene(const results::ResultFile& file, std::size_t axis) {
  const std::optional<plan::Plan> plan = ReadPlan(file);
  if (!plan) return file.axes()[axis].IsText();
  std::map<Point, const plan::Scene*> firsts;
  for (const plan::Run& run : plan->runs) {
    const auto [first, is_new] = firsts.emplace(Without(run.at, axis), &run.scene);
    if (!is_new && AreDifferentScenes(*first->second, run.scene)) return true;
  }
  return false;
}

bool IsOfScene(const results::ResultFile& file, std::size_t index) {
  const plan::Axis& axis = file.axes()[index];
  if (axis.parameter.empty()) return ChangesScene(file, index);
  for (const schema::Parameter& parameter : schema::Schema()) {
    // A group's name precedes its parameter: `pebbles.size`.
    const bool is_it = parameter.grouped
                           ? axis.parameter.ends_with("." + std::string(parameter.OwnName()))
                           : axis.parameter == parameter.name;
    if (is_it) return parameter.concern == schema::Concern::kScene;
  }
  return false;
}

}  // namespace

std::vector<std::size_t> SceneAxes(const results::ResultFile& file) {
  std::vector<std::size_t> axes;
  for (std::size_t i = 0; i < file.axes().size(); ++i)
    if (IsOfScene(file, i)) axes.push_back(i);
  return axes;
}

}  // namespace cdb::figures
