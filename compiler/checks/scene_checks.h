// Errors of a whole scene whose settings are valid one by one: too many bodies, the omission of a
// component that it needs, errors that cannot be collected, settings without a meaning on a trace.
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "compiler/analysis/pruning.h"
#include "compiler/configure/configuration.h"
#include "compiler/plan/plan.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// The scenes of one benchmark, which share what is wrong with most of them: each fault is reported
/// once. Not for several threads.
class SceneChecks {
 public:
  /// `benchmark`: where its name stands, for what no setting is to blame for.
  SceneChecks(text::Span benchmark, dsl::Diagnostics& diagnostics)
      : benchmark_(benchmark), diagnostics_(diagnostics) {}

  /// Of the scene at the chosen point of `configuration`. False where something is wrong.
  bool Pass(configure::Configuration& configuration, const plan::Scene& scene);
  /// The same of a scene whose detector is run on a trace, which becomes a scene of that trace.
  bool PassTraced(configure::Configuration& configuration, plan::Scene& scene);

 private:
  bool Trace(configure::Configuration& configuration, plan::Scene& scene);
  bool CheckCounts(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckPlaces(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckTable(configure::Configuration& configuration, const plan::Group& group);
  bool CheckMotion(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckCollisions(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckLinks(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckOmit(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckAccuracy(configure::Configuration& configuration, const plan::Scene& scene);

  text::Span benchmark_;
  dsl::Diagnostics& diagnostics_;
  // As reported:
  bool capacity_reported_ = false;
  std::set<std::pair<std::string, std::string>>
      misplaced_;  ///< groups, and their layouts or what is wrong with their links
  /// Words of `omit` that were refused: the reason may be another one in each run.
  std::set<std::tuple<const text::Source*, std::size_t, schema::Component>> refused_;
  std::set<std::pair<scenario::ParameterKey, std::string>>
      untraceable_;          ///< settings, and words of `record`, that do not go with a trace
  bool inaccurate_ = false;  ///< a fault in what is said of accuracy

  std::optional<double> interval_s_;  ///< of the samples, once some run has any
};

}  // namespace cdb::checks
