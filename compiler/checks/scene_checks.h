// Errors of a whole scene whose settings are valid one by one: too many bodies, omission of a
// component that it needs, errors that cannot be measured, settings without a meaning on a trace.
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "compiler/analysis/pruning.h"
#include "compiler/analysis/trace.h"
#include "compiler/configure/configuration.h"
#include "compiler/plan/plan.h"
#include "compiler/scenario/layers.h"
#include "compiler/schema/series.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// The fault of one setting in a scene that is run on a trace, or checked in configurations.
struct LaidFault {
  const dsl::DiagnosticKind* kind = nullptr;
  scenario::ParameterKey key;
  std::string word = {};  ///< of the list in the setting; empty: the whole setting
  std::string message, help;
};

/// Checks the scenes of one benchmark. Each fault is reported once, as most scenes share it. Not
/// thread-safe.
class SceneChecks {
 public:
  /// `benchmark`: the location of its name, for faults that no single setting causes.
  SceneChecks(text::Span benchmark, dsl::Diagnostics& diagnostics)
      : benchmark_(benchmark), diagnostics_(diagnostics) {}

  /// Checks the scene at the chosen point of `configuration`. False if it has a fault.
  bool Pass(configure::Configuration& configuration, const plan::Scene& scene);
  /// Does the same for a scene whose detector is run on a trace, and turns it into a scene of the
  /// trace.
  bool PassTraced(configure::Configuration& configuration, plan::Scene& scene);
  /// Does the same for a scene that is checked in configurations of its joints.
  bool PassConfigurations(configure::Configuration& configuration, plan::Scene& scene);

 private:
  bool Trace(configure::Configuration& configuration, plan::Scene& scene);
  void Report(configure::Configuration& configuration, const std::vector<LaidFault>& faults);
  bool CheckCounts(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckMeasurement(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckPlaces(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckTable(configure::Configuration& configuration, const plan::Scene& scene,
                  const plan::Group& group);
  void WarnOfMissedPath(configure::Configuration& configuration, const plan::Scene& scene,
                        const plan::Group& group, const analysis::PoseFacts& facts);
  bool CheckMotion(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckCollisions(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckGroupsInCalls(configure::Configuration& configuration, const plan::Scene& scene,
                          const plan::Group& group);
  void ReportUnknownGroup(const text::Span& span, const std::string& word,
                          const std::vector<std::string_view>& names);
  bool CheckLinks(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckJoints(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckTimeTables(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckQueries(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckKinds(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckOmit(configure::Configuration& configuration, const plan::Scene& scene);
  bool CheckAccuracy(configure::Configuration& configuration, const plan::Scene& scene);

  text::Span benchmark_;
  dsl::Diagnostics& diagnostics_;
  // Faults already reported.
  bool capacity_reported_ = false;
  std::set<std::pair<std::string, std::string>>
      misplaced_;  ///< groups, and their layout or the fault of their links
  /// Words of `omit` already rejected: the reason can differ between runs.
  std::set<std::tuple<const text::Source*, std::size_t, schema::Component>> refused_;
  std::set<std::pair<scenario::ParameterKey, std::string>>
      unlaid_;  ///< settings, and words of `record`, that a trace or configurations do not take
  bool inaccurate_ = false;  ///< a fault in the settings of accuracy

  std::optional<double> interval_s_;  ///< of the samples, once a run has any
};

/// Adds a fault for each word of `record` whose row has not `is_recordable`; `where`: why, after
/// "cannot be recorded".
void AddRecordFaults(const plan::Scene& scene, bool schema::RecordWord::*is_recordable,
                     std::string_view where, std::vector<LaidFault>& faults);

// A scene whose detector is run on a trace, and the settings that still apply to it.

/// Gives `scene` the properties of the trace: one object per body, no walls, its time step and
/// precision, all of its cycles and everything that can be recorded, unless `layers` sets
/// otherwise. Returns the settings of `layers` that have no meaning with a trace.
std::vector<LaidFault> LayTrace(const scenario::Layers& layers, const analysis::TraceFacts& facts,
                                plan::Scene& scene);

}  // namespace cdb::checks
