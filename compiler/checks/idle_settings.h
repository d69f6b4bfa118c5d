// Settings of a benchmark that have no effect in any of its runs.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>

#include "compiler/configure/configuration.h"
#include "compiler/grid/grid.h"
#include "compiler/plan/plan.h"
#include "compiler/scenario/scenario.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// Velocities of fixed objects, kinematic objects without motion, and expectations of driven
/// scenes. Not thread-safe.
class IdleSettings {
 public:
  /// `benchmark`: the location of its name, for findings that no single setting causes.
  IdleSettings(text::Span benchmark, dsl::Diagnostics& diagnostics)
      : benchmark_(benchmark), diagnostics_(diagnostics) {}

  /// Adds the scene at the chosen point of `configuration`.
  void Add(configure::Configuration& configuration, const plan::Scene& scene);
  /// Warns of settings that had no effect in every scene added.
  void Report() const;

 private:
  struct Finding {
    text::Span span;
    std::string message, help;
  };
  void Look(configure::Configuration& configuration, const scenario::ParameterKey& key,
            bool is_idle, const std::string& message, const std::string& help);

  text::Span benchmark_;
  dsl::Diagnostics& diagnostics_;
  std::map<scenario::ParameterKey, Finding> idle_;
  std::set<scenario::ParameterKey> useful_;  ///< those with an effect in some scene
};

// Parts of a benchmark that no run uses: values of axes, cases, axes and settings.

/// Warns of parts of the benchmark's own block, not of those from a base: values of an axis and
/// cases that `skip` leaves out at every point, sweeps in an unused let, and settings that every
/// case overrides. `grid` is the benchmark's.
void ReportUnreachable(const scenario::Scenario& scenario, const scenario::BenchmarkRef& benchmark,
                       const grid::Grid& grid, dsl::Diagnostics& diagnostics);

/// Warns of an unused let of the file that is a sweep.
void ReportUnusedSweep(const dsl::Let& let, dsl::Diagnostics& diagnostics);

}  // namespace cdb::checks
