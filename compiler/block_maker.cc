#include "compiler/block_maker.h"

#include <algorithm>
#include <string>
#include <utility>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/trace.h"
#include "compiler/checks/configuration_checks.h"
#include "compiler/checks/scene_checks.h"
#include "compiler/configure/axes.h"
#include "dsl/text/check.h"

namespace cdb::compiler {
namespace {

using grid::Point;
using grid::PointCondition;

/// The maximum number of errors reported for one setting.
constexpr int kMostErrors = 1000;

/// The values of an axis of words.
std::vector<std::string> WordsOf(const plan::Axis& axis) {
  std::vector<std::string> words;
  for (const plan::Coordinate& word : axis.values) words.push_back(std::get<std::string>(word));
  return words;
}

/// A coordinate for conditions: exact if all numbers of its axis are integers.
schema::Value ConditionValue(const plan::Axis& axis, std::size_t index, bool is_integer) {
  const auto* real = std::get_if<double>(&axis.values[index]);
  if (real == nullptr) return schema::Word{std::get<std::string>(axis.values[index])};
  if (is_integer) return schema::Number::Whole(static_cast<schema::Integer>(*real));
  return *real;
}

/// True if Block::complete may depend on the value: a drawn value has a seed.
bool DecidesSeedsOrPlugins(const schema::Parameter& parameter,
                           const std::vector<schema::Value>& values) {
  const auto is_plain = [](const schema::Value& value) {
    return std::holds_alternative<bool>(value) || std::holds_alternative<schema::Number>(value) ||
           std::holds_alternative<Eigen::Vector3d>(value) ||
           std::holds_alternative<schema::Ratio>(value);
  };
  return &parameter == schema::WorldParameter("seed").get() ||
         !std::ranges::all_of(values, is_plain);
}

}  // namespace

BlockMaker::BlockMaker(std::shared_ptr<const scenario::Scenario> scenario,
                       std::shared_ptr<configure::Configuration> configuration,
                       const std::vector<plan::Axis>& axes, std::vector<Point> places)
    : scenario_(std::move(scenario)),
      configuration_(std::move(configuration)),
      axes_(axes),
      places_(std::move(places)) {
  for (const Point& values : places_) extents_.push_back(values.size());
  for (const plan::Axis& axis : axes_) is_integer_.push_back(axis.IsInteger());
  for (const configure::SweepAxis& sweep : configuration_->axes())
    axis_of_sweep_.push_back(static_cast<std::size_t>(
        std::ranges::find(axes_, sweep.name, &plan::Axis::name) - axes_.begin()));
}

void BlockMaker::Choose(const Point& local) {
  configure::Point point;
  for (const std::size_t axis : axis_of_sweep_) point.push_back(local[axis]);
  configuration_->Choose(point);
}

grid::Block BlockMaker::MakeConditions() {
  grid::Block block;
  block.places = places_;
  block.extents = extents_;
  block.complete = [scenario = scenario_, configuration = configuration_](plan::Scene& scene) {
    configuration->Complete(scene);
  };
  block.lay = [scenario = scenario_, configuration = configuration_](plan::Scene& scene) {
    if (analysis::HasConfigurations(scene)) {
      checks::LayConfigurations(*scenario, configuration->layers(), scene);
      return;
    }
    std::string why;
    const auto facts = scenario->TraceAt(analysis::TraceOf(scene)->path, why);
    CDB_CHECK(facts);
    checks::LayTrace(configuration->layers(), *facts, scene);
  };
  Choose(Point(extents_.size(), 0));
  for (const auto& skip : configuration_->layers().skips) {
    if (!skip.node->when) continue;  // an error that was reported
    PointCondition condition = Table(*skip.node->when, skip.scope);
    if (skip.node->is_only)
      condition = {PointCondition::Kind::kNot, {}, {}, {std::move(condition)}};
    block.skips.push_back(std::move(condition));
  }
  return block;
}

void BlockMaker::SetAxis(std::size_t axis, std::size_t local) {
  configure::Conditions& conditions = configuration_->conditions();
  conditions.SetAxis(axes_[axis].name,
                     ConditionValue(axes_[axis], places_[axis][local], is_integer_[axis]));
  if (axes_[axis].IsText() && !conditions.HasAxisWords(axes_[axis].name))
    conditions.SetAxisWords(axes_[axis].name, WordsOf(axes_[axis]));
}

grid::AxisSet BlockMaker::AxesIn(const dsl::Expr& expr, const scenario::Scope& scope) const {
  grid::AxisSet found;
  for (std::size_t axis = 0; axis < axes_.size(); ++axis)
    if (expr.kind == dsl::ExprKind::kPath && axes_[axis].name == expr.text) found.push_back(axis);
  const auto sweeps =
      configure::SweepsIn(expr, scope, configuration_->layers(), configuration_->evaluator());
  for (std::size_t i = 0; i < axis_of_sweep_.size(); ++i)
    if (sweeps.contains(configuration_->axes()[i].call))
      found = grid::Union(found, {axis_of_sweep_[i]});
  return found;
}

PointCondition BlockMaker::Table(const dsl::Condition& condition, const scenario::Scope& scope) {
  using enum dsl::ConditionKind;
  PointCondition table;
  if (condition.kind != kCompare && condition.kind != kIn) {
    table.kind = condition.kind == kNot   ? PointCondition::Kind::kNot
                 : condition.kind == kAnd ? PointCondition::Kind::kAnd
                                          : PointCondition::Kind::kOr;
    for (const auto& item : condition.items) table.items.push_back(Table(*item, scope));
    return table;
  }
  grid::AxisSet axes = AxesIn(*condition.left, scope);
  if (condition.right) axes = grid::Union(axes, AxesIn(*condition.right, scope));
  for (const auto& value : condition.values) axes = grid::Union(axes, AxesIn(*value, scope));
  table.by = grid::Subgrid(axes, extents_);
  Point local(extents_.size(), 0);
  for (std::size_t axis = 0; axis < axes_.size(); ++axis) SetAxis(axis, 0);
  do {
    Choose(local);
    for (const std::size_t axis : table.by.axes()) SetAxis(axis, local[axis]);
    table.values.push_back(configuration_->conditions().Hold(condition, scope));
  } while (table.by.Advance(local));
  return table;
}

const grid::Remaining& BlockMaker::RemainingAlong(const grid::AxisSet& axes,
                                                  const grid::Block& block) {
  const auto [known, is_new] = remaining_.try_emplace(axes);
  if (is_new) known->second = grid::RemainingBy(block, axes);
  return known->second;
}

bool BlockMaker::AddSettings(grid::Block& block) {
  for (const std::string& group : configuration_->layers().groups)
    block.base.groups.push_back({group, {}});
  for (const std::string& joint : configuration_->layers().joints)
    block.base.joints.push_back({joint, {}});
  for (const std::string& queries : configuration_->layers().queries)
    block.base.queries.push_back({queries, {}});
  std::vector<PointCondition> bad;
  for (const configure::DependentParameter& parameter : configuration_->parameters())
    if (parameter.key.second->concern != schema::Concern::kReport)
      AddSetting(parameter, block, bad);
  block.skips.insert(block.skips.end(), bad.begin(), bad.end());
  return bad.empty();
}

void BlockMaker::AddSetting(const configure::DependentParameter& parameter, grid::Block& block,
                            std::vector<PointCondition>& bad) {
  grid::AxisSet axes;
  for (const std::size_t axis : parameter.axes) axes = grid::Union(axes, {axis_of_sweep_[axis]});
  axes = grid::WithoutConstants(axes, extents_);
  const schema::Parameter& row = *parameter.key.second;
  grid::VaryingSetting setting{grid::VaryingSetting::kWorld, &row, grid::Subgrid(axes, extents_)};
  std::size_t before = 0;
  const auto find = [&](const auto& groups) {
    for (std::size_t i = 0; i < groups.size(); ++i)
      if (groups[i].name == parameter.key.first) setting.group = before + i;
    before += groups.size();
  };
  find(block.base.groups);
  find(block.base.joints);
  find(block.base.queries);
  const grid::Remaining& remaining = RemainingAlong(axes, block);
  std::vector<bool> is_bad(remaining.counts.size(), false);
  int errors = 0;
  setting.values.resize(remaining.counts.size());
  Point local(extents_.size(), 0);
  do {
    const auto index = static_cast<std::size_t>(setting.by.IndexOf(local));
    if (remaining.counts[index] == 0 || errors >= kMostErrors) continue;
    Choose(local);
    auto value = configuration_->ValueOf(parameter.key);
    is_bad[index] = !value;
    errors += !value;
    if (value) setting.values[index] = std::move(*value);
  } while (setting.by.Advance(local));
  if (errors > 0) bad.push_back({PointCondition::Kind::kTable, setting.by, std::move(is_bad), {}});
  setting.completes = DecidesSeedsOrPlugins(row, setting.values);
  if (setting.values.size() > 1) {
    block.varying.push_back(std::move(setting));
  } else {
    setting.SettingsIn(block.base).SetValue(row, std::move(setting.values[0]));
  }
}

}  // namespace cdb::compiler
