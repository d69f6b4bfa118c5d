// A scene whose detector is run on a trace: what still means something there.
#pragma once

#include <string>
#include <vector>

#include "compiler/analysis/trace.h"
#include "compiler/scenario/layers.h"
#include "dsl/diagnostics.h"

namespace cdb::checks {

/// What is wrong with one setting.
struct TracedFault {
  const dsl::DiagnosticKind* kind = nullptr;
  scenario::ParameterKey key;
  std::string word;  ///< of the list that it is set to; empty: the setting as a whole
  std::string message, help;
};

/// Gives `scene` what the trace says: as many objects as it has bodies, no walls, its time step and
/// precision, all of its cycles and what can be recorded, where `layers` does not say otherwise.
/// Returns what `layers` says that means nothing with it.
std::vector<TracedFault> LayTrace(const scenario::Layers& layers, const analysis::TraceFacts& facts,
                                  plan::Scene& scene);

}  // namespace cdb::checks
