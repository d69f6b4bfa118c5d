// Makes a block of a grid from a benchmark under one choice of its cases.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "compiler/configure/configuration.h"
#include "compiler/grid/grid.h"
#include "compiler/scenario/scenario.h"

namespace cdb::compiler {

/// Evaluates each condition and each setting once for each combination of values of the axes that
/// it depends on. Not thread-safe.
class BlockMaker {
 public:
  /// `axes`: those of the grid; `places`: as Block::places. Both must outlive this object.
  BlockMaker(std::shared_ptr<const scenario::Scenario> scenario,
             std::shared_ptr<configure::Configuration> configuration,
             const std::vector<plan::Axis>& axes, std::vector<grid::Point> places);

  /// Chooses a point of the block for the configuration.
  void Choose(const grid::Point& local);
  configure::Configuration& configuration() { return *configuration_; }

  /// Makes everything except the settings. Errors of conditions are reported.
  grid::Block MakeConditions();
  /// Adds the settings to the result of MakeConditions. False after diagnostics; points with
  /// invalid settings are then left out, so that the others can be checked.
  bool AddSettings(grid::Block& block);

 private:
  grid::PointCondition Table(const dsl::Condition& condition, const scenario::Scope& scope);
  grid::AxisSet AxesIn(const dsl::Expr& expr, const scenario::Scope& scope) const;
  void SetAxis(std::size_t axis, std::size_t local);
  /// Adds to `bad` a condition that selects the points with an invalid value.
  void AddSetting(const configure::DependentParameter& parameter, grid::Block& block,
                  std::vector<grid::PointCondition>& bad);
  const grid::Remaining& RemainingAlong(const grid::AxisSet& axes, const grid::Block& block);

  std::shared_ptr<const scenario::Scenario> scenario_;
  std::shared_ptr<configure::Configuration> configuration_;
  const std::vector<plan::Axis>& axes_;
  std::vector<grid::Point> places_;
  grid::Point extents_;
  std::vector<bool> is_integer_;            ///< by axis
  std::vector<std::size_t> axis_of_sweep_;  ///< the grid's axis, by the configuration's axis
  std::map<grid::AxisSet, grid::Remaining> remaining_;
};

}  // namespace cdb::compiler
