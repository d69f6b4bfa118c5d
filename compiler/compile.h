// Compiles a scenario file to plans: the entry point of the compiler.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/scene_fault.h"
#include "compiler/checks/idle_settings.h"
#include "compiler/checks/scene_checks.h"
#include "compiler/checks/scene_faults.h"
#include "compiler/grid/grid.h"
#include "compiler/grid/survey.h"
#include "compiler/lints/lint_findings.h"
#include "compiler/plan/plan.h"
#include "compiler/scenario/scenario.h"
#include "dsl/diagnostics.h"

namespace cdb::compiler {

struct CompileOptions {
  std::string library;  ///< folder of the scenarios that any file can `use`; may be empty
  std::optional<std::string> benchmark;  ///< the only one to compile; nullopt: all of the file
  scenario::PluginSource plugins = {};
  analysis::ReadTrace read_trace = {};  ///< if empty, no `trace` can be read
  /// If empty, impossible placements and wrong closed forms show only in runs.
  analysis::FindSceneFault find_fault = {};
  analysis::ReadPoses read_poses = {};  ///< if empty, no `location poses("file")` can be read
  analysis::ReadModel read_model = {};  ///< if empty, meshes are not checked
  analysis::ReadRobot read_robot = {};  ///< if empty, no robot can be read
  /// Fills Compilation::plans; a benchmark with more than kMostListed runs is then an error.
  bool lists_runs = true;
};

/// The maximum number of runs of a plan held in memory run by run.
inline constexpr std::uint64_t kMostListed = 100'000;

/// The result of a compilation. Diagnostics point into `scenario`, which must outlive them.
struct Compilation {
  std::shared_ptr<const scenario::Scenario> scenario;
  dsl::Diagnostics diagnostics;
  std::vector<grid::Grid> grids;        ///< empty after errors
  std::vector<plan::Plan> plans;        ///< of `grids`, run by run, if requested
  std::vector<std::string> benchmarks;  ///< names of those in the file
};

/// Checks the whole file and reports every error, also of benchmarks that are not compiled. Never
/// throws.
Compilation Compile(const std::string& path, const scenario::ReadFile& read,
                    const CompileOptions& options = {});

/// Reads a file from disk.
std::optional<std::string> ReadFromDisk(const std::string& path, std::string& why);

// Adds an axis to a plan: the parameter swept on a command line.

/// The plan with an axis for `parameter` of the world in front of the others, with `words` as its
/// values, all of which must be known to the schema or, for detectors, be in `plugins`. A plan that
/// already sweeps the parameter is returned unchanged.
plan::Plan Cross(const plan::Plan& plan, schema::WorldParameter parameter,
                 const std::vector<std::string>& words,
                 std::span<const schema::PluginDetector> plugins = {});

// Expands a benchmark to the grid of its runs, with all settings as values.

/// Nullopt after diagnostics. `Compile` fills in title and texts of the plan. `find_fault` checks
/// scenes; may be empty. `lints`: warn of numbers that Bullet cannot simulate accurately
/// (compiler/lints/lints.h), each once with its worst run.
std::optional<grid::Grid> Expand(std::shared_ptr<const scenario::Scenario> scenario,
                                 const scenario::BenchmarkRef& benchmark,
                                 const analysis::FindSceneFault& find_fault,
                                 dsl::Diagnostics& diagnostics, bool lints);

// Checks of scenes, and warnings about them, over all runs of a grid.

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
