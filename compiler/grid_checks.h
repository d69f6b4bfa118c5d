// Checks of scenes, and warnings about them, over all runs of a grid.
#pragma once

#include <functional>
#include <vector>

#include "compiler/checks/idle_settings.h"
#include "compiler/checks/scene_checks.h"
#include "compiler/checks/scene_faults.h"
#include "compiler/grid/survey.h"
#include "compiler/lints/lint_findings.h"

namespace cdb::compiler {

/// Chooses a point of a block of the grid in its configuration, and returns that configuration.
using ChoosePoint =
    std::function<configure::Configuration&(std::size_t block, const grid::Point& local)>;

/// Each check is made once for all runs that agree in the settings it reads. Not thread-safe.
class GridChecks {
 public:
  /// `benchmark`: the location of its name. `grid` must outlive this object.
  GridChecks(const grid::Grid& grid, ChoosePoint choose, text::Span benchmark,
             dsl::Diagnostics& diagnostics)
      : grid_(grid),
        choose_(std::move(choose)),
        benchmark_(benchmark),
        diagnostics_(diagnostics),
        survey_(grid) {}

  /// Checks the combinations of settings of every run.
  void Check();
  /// Finds scenes that cannot be built: among all runs, or as many as take a second or two.
  void FindFaults(const analysis::FindSceneFault& find);
  /// Warns of settings without effect and of numbers that Bullet cannot simulate accurately: for
  /// every run, or for about kMostLinted spread over the grid.
  void Lint();

  /// The maximum number of combinations of settings that are checked.
  static constexpr std::uint64_t kMostLinted = 40'000, kMostPlaced = 2'000;
  /// The maximum number of placed objects if not all combinations are checked.
  static constexpr std::uint64_t kMostObjectsOfMany = 50'000;

 private:
  grid::AxisSet AxesOfPlacement() const;
  void Replay(const dsl::Diagnostics& found);

  const grid::Grid& grid_;
  ChoosePoint choose_;
  text::Span benchmark_;
  dsl::Diagnostics& diagnostics_;
  grid::Survey survey_;
};

}  // namespace cdb::compiler
