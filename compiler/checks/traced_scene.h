// A scene whose detector is run on a trace, and the settings that still apply to it.
#pragma once

#include <string>
#include <vector>

#include "compiler/analysis/trace.h"
#include "compiler/scenario/layers.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// The fault of one setting.
struct TracedFault {
  const dsl::DiagnosticKind* kind = nullptr;
  scenario::ParameterKey key;
  std::string word;  ///< of the list in the setting; empty: the whole setting
  std::string message, help;
};

/// Gives `scene` the properties of the trace: one object per body, no walls, its time step and
/// precision, all of its cycles and everything that can be recorded, unless `layers` sets
/// otherwise. Returns the settings of `layers` that have no meaning with a trace.
std::vector<TracedFault> LayTrace(const scenario::Layers& layers, const analysis::TraceFacts& facts,
                                  plan::Scene& scene);

}  // namespace cdb::checks
