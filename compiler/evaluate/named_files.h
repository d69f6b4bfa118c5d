// Files that a scenario names: models and traces.
#pragma once

#include <optional>
#include <vector>

#include "compiler/evaluate/term.h"
#include "compiler/scenario/scenario.h"
#include "dsl/diagnostics.h"

namespace cdb::evaluate {

/// Gives `call` the path of its file and its hash. `arguments` are the name and the expected hash
/// as written. False after a diagnostic.
bool ReadNamedFile(const scenario::Scenario& scenario, const std::vector<Term>& arguments,
                   schema::Call& call, dsl::Diagnostics& diagnostics);

/// The call that the text behind `trace` stands for.
std::optional<schema::Call> TraceNamed(const scenario::Scenario& scenario, const Term& name,
                                       dsl::Diagnostics& diagnostics);

}  // namespace cdb::evaluate
