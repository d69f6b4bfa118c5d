#include "compiler/grid_checks.h"

#include <limits>
#include <optional>

#include "compiler/analysis/trace.h"

namespace cdb::compiler {

void GridChecks::Replay(const dsl::Diagnostics& found) {
  for (const dsl::Diagnostic& one : found.all())
    diagnostics_.Report(*one.kind, one.span, one.message, one.help, one.notes);
}

void GridChecks::Check() {
  std::optional<dsl::Diagnostics> found;
  std::optional<checks::SceneChecks> checks;
  survey_.Look(
      std::numeric_limits<std::uint64_t>::max(), {},
      [&](bool) { checks.emplace(benchmark_, found.emplace()); },
      [&](const grid::Sample& sample, const plan::Scene& scene) {
        configure::Configuration& configuration = choose_(sample.block, sample.local);
        if (!analysis::TraceOf(scene)) {
          checks->Pass(configuration, scene);
        } else {
          plan::Scene traced = scene;
          checks->PassTraced(configuration, traced);
        }
      });
  Replay(*found);
}

/// The axes that determine the placement, so that no scene is placed twice. A closed form may
/// depend on every axis.
grid::AxisSet GridChecks::AxesOfPlacement() const {
  grid::AxisSet axes;
  constexpr schema::WorldParameter kClosedForm = "accuracy.closed_form", kSeed = "seed",
                                   kSide = "world.side", kTrace = "trace";
  bool has_closed_form = false;
  for (const grid::Block& block : grid_.blocks) {
    has_closed_form = has_closed_form || block.base.world.WordOr("accuracy.closed_form") != "none";
    for (const grid::VaryingSetting& setting : block.varying) {
      const schema::Parameter* parameter = setting.parameter;
      has_closed_form = has_closed_form || parameter == kClosedForm.get();
      if (parameter->grouped || parameter == kSeed.get() || parameter == kSide.get() ||
          parameter == kTrace.get())
        axes = grid::Union(axes, setting.by.axes());
    }
  }
  return has_closed_form ? grid::AllAxes(grid_.head.axes.size()) : axes;
}

void GridChecks::FindFaults(const analysis::FindSceneFault& find) {
  std::optional<dsl::Diagnostics> found;
  std::optional<checks::SceneFaults> faults;
  survey_.Look(
      kMostPlaced, AxesOfPlacement(),
      [&](bool is_whole) {
        faults.emplace(benchmark_, find, found.emplace(),
                       is_whole ? checks::SceneFaults::kMostObjects : kMostObjectsOfMany);
      },
      [&](const grid::Sample& sample, const plan::Scene& scene) {
        if (!analysis::TraceOf(scene))
          faults->Add(choose_(sample.block, sample.local), scene,
                      sample.points * grid_.head.repeats);
      });
  faults->Report(grid_.run_count());
  Replay(*found);
}

void GridChecks::Lint() {
  std::optional<lints::LintFindings> findings;
  std::optional<checks::IdleSettings> idle;
  std::uint64_t looked_at = 0;
  survey_.Look(
      kMostLinted, {},
      [&](bool) {
        findings.emplace(benchmark_, diagnostics_);
        idle.emplace(benchmark_, diagnostics_);
        looked_at = 0;
      },
      [&](const grid::Sample& sample, const plan::Scene& scene) {
        const std::uint64_t runs = sample.points * grid_.head.repeats;
        looked_at += runs;
        if (analysis::TraceOf(scene)) return;
        configure::Configuration& configuration = choose_(sample.block, sample.local);
        findings->Add(configuration, scene, runs);
        idle->Add(configuration, scene);
      });
  idle->Report();
  findings->Report(looked_at, grid_.run_count());
}

}  // namespace cdb::compiler
