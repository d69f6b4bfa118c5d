// A scene whose detector is run on a trace: what still means something there.
#pragma once

#include <string>
#include <vector>

#include "compiler/layers.h"
#include "compiler/trace.h"
#include "dsl/diagnostics.h"

namespace cdb::compiler {

/// What is wrong with one setting.
struct TracedFault {
  const dsl::DiagnosticKind* kind = nullptr;
  ParameterKey key;
  std::string word;  ///< of the list that it is set to; empty: the setting as a whole
  std::string message, help;
};

/// Gives `scene` what the trace says: as many objects as it has bodies, no walls, its time step and
/// precision, all of its cycles and what can be recorded, where `layers` does not say otherwise.
/// Returns what `layers` says that means nothing with it.
std::vector<TracedFault> LayTrace(const Layers& layers, const TraceFacts& facts, Scene& scene);

}  // namespace cdb::compiler
