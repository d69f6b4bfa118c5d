// The checks of scenes, and the warnings about them, over all runs of a grid.
#pragma once

#include <functional>
#include <vector>

#include "compiler/checks/idle_settings.h"
#include "compiler/checks/scene_checks.h"
#include "compiler/checks/scene_faults.h"
#include "compiler/grid/survey.h"
#include "compiler/lints/lint_findings.h"

namespace cdb::compiler {

/// Chooses a point of a block of the grid for its configuration, and returns that.
using ChoosePoint =
    std::function<configure::Configuration&(std::size_t block, const grid::Point& local)>;

/// Each check is made once for all runs that agree in what it reads. Not for several threads.
class GridChecks {
 public:
  /// `benchmark`: where its name stands. `grid` outlives this object.
  GridChecks(const grid::Grid& grid, ChoosePoint choose, text::Span benchmark,
             dsl::Diagnostics& diagnostics)
      : grid_(grid),
        choose_(std::move(choose)),
        benchmark_(benchmark),
        diagnostics_(diagnostics),
        survey_(grid) {}

  /// Errors that settings make together, of every run.
  void Check();
  /// Scenes that cannot be built: of every run, or of as many as take a second or two.
  void FindFaults(const analysis::FindSceneFault& find);
  /// Settings without effect, and numbers that Bullet cannot follow: of every run, or of about
  /// kMostLinted spread over the grid.
  void Lint();

  /// Combinations of settings that are looked at.
  static constexpr std::uint64_t kMostLinted = 40'000, kMostPlaced = 2'000;
  /// Objects that are placed where not all combinations are looked at.
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
