// Files named in a scenario: models and traces.
#pragma once

#include <optional>

#include "compiler/scenario/scenario.h"
#include "compiler/schema/value.h"
#include "dsl/diagnostics.h"

namespace cdb::names {

/// Replaces the arguments of `call`, the name of a file and its expected hash as written, by the
/// path of the file and its hash. False after a diagnostic.
bool ReadNamedFile(const scenario::Scenario& scenario, schema::Call& call,
                   dsl::Diagnostics& diagnostics);

/// The call that a text after `trace` stands for.
std::optional<schema::Call> TraceNamed(const scenario::Scenario& scenario, const schema::Text& name,
                                       dsl::Diagnostics& diagnostics);

}  // namespace cdb::names
