#include "compiler/grid/grid.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/trace.h"
#include "compiler/yaml/plan_yaml.h"

namespace cdb::grid {
namespace {

constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);
constexpr std::uint64_t kNotChosen = std::numeric_limits<std::uint64_t>::max();

Subgrid WholeGrid(const Grid& grid) { return {AllAxes(grid.head.axes.size()), grid.extents()}; }

}  // namespace

bool PointCondition::Holds(const Point& point) const {
  switch (kind) {
    case Kind::kTable:
      return values[by.IndexOf(point)];
    case Kind::kNot:
      return !items[0].Holds(point);
    case Kind::kAnd:
      return std::ranges::all_of(items, [&](const auto& item) { return item.Holds(point); });
    case Kind::kOr:
      return std::ranges::any_of(items, [&](const auto& item) { return item.Holds(point); });
  }
  return false;
}

AxisSet PointCondition::axes() const {
  AxisSet all = by.axes();
  for (const PointCondition& item : items) all = Union(all, item.axes());
  return all;
}

plan::Settings& VaryingSetting::SettingsIn(plan::Scene& scene) const {
  if (group == kWorld) return scene.world;
  std::size_t index = group;
  if (index < scene.groups.size()) return scene.groups[index].settings;
  index -= scene.groups.size();
  if (index < scene.joints.size()) return scene.joints[index].settings;
  return scene.queries[index - scene.joints.size()].settings;
}

bool Block::IsSkipped(const Point& local) const {
  return std::ranges::any_of(skips, [&](const auto& skip) { return skip.Holds(local); });
}

AxisSet Block::SkipAxes() const {
  AxisSet all;
  for (const PointCondition& skip : skips) all = Union(all, skip.axes());
  return all;
}

AxisSet Block::AxesOf(const schema::Parameter& parameter) const {
  AxisSet all;
  for (const VaryingSetting& setting : varying)
    if (setting.parameter == &parameter) all = Union(all, setting.by.axes());
  return all;
}

Point Block::PlaceOf(const Point& local) const {
  Point place(local.size());
  for (std::size_t axis = 0; axis < local.size(); ++axis) place[axis] = places[axis][local[axis]];
  return place;
}

Remaining RemainingBy(const Block& block, const AxisSet& axes) {
  const Subgrid whole(AllAxes(block.extents.size()), block.extents);
  const Subgrid looked_at(Union(Subgrid(axes, block.extents).axes(), block.SkipAxes()),
                          block.extents);
  // Points that differ only in other axes are skipped together.
  const std::uint64_t alike = whole.size() / looked_at.size();
  Remaining remaining{Subgrid(axes, block.extents), {}, {}};
  remaining.counts.assign(remaining.by.size(), 0);
  remaining.firsts.assign(remaining.by.size(), 0);
  Point point(block.extents.size(), 0);
  do {
    if (block.IsSkipped(point)) continue;
    const std::uint64_t index = remaining.by.IndexOf(point);
    const std::uint64_t here = whole.IndexOf(point);
    if (remaining.counts[index] == 0 || here < remaining.firsts[index])
      remaining.firsts[index] = here;
    remaining.counts[index] += alike;
  } while (looked_at.Advance(point));
  return remaining;
}

Point Grid::extents() const {
  Point extents;
  for (const plan::Axis& axis : head.axes) extents.push_back(axis.values.size());
  return extents;
}

Cursor::Cursor(const Grid& grid) : grid_(grid) {
  const Point extents = grid.extents();
  for (const Block& block : grid.blocks) {
    states_.push_back({block.base, std::vector<std::uint64_t>(block.varying.size(), kNotChosen)});
    std::vector<Point> locals;
    for (std::size_t axis = 0; axis < extents.size(); ++axis) {
      locals.emplace_back(extents[axis], kNowhere);
      for (std::size_t i = 0; i < block.places[axis].size(); ++i)
        locals.back()[block.places[axis][i]] = i;
    }
    locals_.push_back(std::move(locals));
  }
  local_.assign(extents.size(), 0);
}

std::size_t Cursor::BlockAt(const Point& place) const {
  std::size_t block = 0;
  for (const std::size_t axis : grid_.case_axes)
    block = block * grid_.head.axes[axis].values.size() + place[axis];
  return block;
}

bool Cursor::FindLocal(const Point& place, Point& local) const {
  const std::size_t block = BlockAt(place);
  for (std::size_t axis = 0; axis < place.size(); ++axis) {
    local[axis] = locals_[block][axis][place[axis]];
    if (local[axis] == kNowhere) return false;
  }
  return !grid_.blocks[block].IsSkipped(local);
}

bool IsLaid(const plan::Scene& configured) {
  return analysis::TraceOf(configured) || analysis::HasConfigurations(configured);
}

bool Cursor::HasRun(const Point& place) const {
  Point local(place.size());
  return FindLocal(place, local);
}

bool Cursor::MoveTo(const Point& place) {
  Point local(place.size());
  if (!FindLocal(place, local)) return false;
  MoveTo(BlockAt(place), local);
  return true;
}

void Cursor::MoveTo(std::size_t block, const Point& local) {
  block_ = block;
  local_ = local;
  const Block& here = grid_.blocks[block];
  State& state = states_[block];
  bool is_incomplete = !std::exchange(state.is_begun, true);
  for (std::size_t i = 0; i < here.varying.size(); ++i) {
    const VaryingSetting& setting = here.varying[i];
    const std::uint64_t index = setting.by.IndexOf(local);
    if (std::exchange(state.chosen[i], index) == index) continue;
    setting.SettingsIn(state.scene).SetValue(*setting.parameter, setting.values[index]);
    is_incomplete = is_incomplete || setting.completes;
  }
  if (is_incomplete && here.complete) here.complete(state.scene);
}

plan::Scene Cursor::MakeScene() const {
  plan::Scene scene = configured();
  if (IsLaid(scene)) grid_.blocks[block_].lay(scene);
  return scene;
}

void ForEachPoint(const Grid& grid,
                  const std::function<bool(const Cursor& cursor, const Point& place)>& visit) {
  Cursor cursor(grid);
  const Subgrid whole = WholeGrid(grid);
  Point place(grid.head.axes.size(), 0);
  do {
    if (cursor.MoveTo(place) && !visit(cursor, place)) return;
  } while (whole.Advance(place));
}

void ForEachSkipped(const Grid& grid, const std::function<void(const Point& place)>& visit) {
  const Subgrid whole = WholeGrid(grid);
  if (grid.point_count == whole.size()) return;
  const Cursor cursor(grid);
  Point place(grid.head.axes.size(), 0);
  do {
    if (!cursor.HasRun(place)) visit(place);
  } while (whole.Advance(place));
}

plan::Plan ListRuns(const Grid& grid, std::uint64_t most) {
  plan::Plan plan = grid.head;
  const bool is_whole = grid.point_count <= most;
  if (is_whole) ForEachSkipped(grid, [&](const Point& place) { plan.skipped.push_back(place); });
  ForEachPoint(grid, [&](const Cursor& cursor, const Point& place) {
    const plan::Scene scene = cursor.MakeScene();
    for (std::uint64_t rep = 0; rep < plan.repeats; ++rep)
      plan.runs.push_back({plan::RunId(scene, rep), place, rep, scene, {}, {}});
    return --most > 0;
  });
  if (is_whole) analysis::AddReferences(plan);
  return plan;
}

void WriteYaml(const Grid& grid, const std::function<void(std::string_view)>& write) {
  yaml::PlanWriter writer(grid.head, write);
  ForEachSkipped(grid, [&](const Point& place) { writer.AddSkipped(place); });
  ForEachPoint(grid, [&](const Cursor& cursor, const Point& place) {
    const bool is_laid = IsLaid(cursor.configured());
    const plan::Scene laid = is_laid ? cursor.MakeScene() : plan::Scene();
    for (std::uint64_t rep = 0; rep < grid.head.repeats; ++rep)
      writer.AddRun(place, rep, is_laid ? laid : cursor.configured());
    return true;
  });
  writer.Finish();
}

AxisSet Union(const AxisSet& a, const AxisSet& b) {
  AxisSet both;
  std::ranges::set_union(a, b, std::back_inserter(both));
  return both;
}

AxisSet AllAxes(std::size_t count) {
  AxisSet all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

AxisSet WithoutConstants(const AxisSet& axes, const Point& extents) {
  AxisSet varying;
  for (const std::size_t axis : axes)
    if (extents[axis] > 1) varying.push_back(axis);
  return varying;
}

double CountOf(const Point& extents) {
  double count = 1;
  for (const std::size_t extent : extents) count *= static_cast<double>(extent);
  return count;
}

Subgrid::Subgrid(AxisSet axes, const Point& extents)
    : axes_(WithoutConstants(axes, extents)), strides_(axes_.size()) {
  for (const std::size_t axis : axes_) extents_.push_back(extents[axis]);
  for (std::size_t i = axes_.size(); i-- > 0;) {
    strides_[i] = size_;
    size_ *= extents_[i];
  }
}

void Subgrid::MoveTo(std::uint64_t index, Point& point) const {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    point[axes_[i]] = static_cast<std::size_t>(index / strides_[i] % extents_[i]);
}

bool Subgrid::Advance(Point& point) const {
  for (std::size_t i = axes_.size(); i-- > 0;) {
    if (++point[axes_[i]] < extents_[i]) return true;
    point[axes_[i]] = 0;
  }
  return false;
}

}  // namespace cdb::grid
