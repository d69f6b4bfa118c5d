// A benchmark to its plan: every point of the grid, with all settings as values.
#pragma once

#include <optional>

#include "compiler/plan/plan.h"
#include "compiler/scenario/scenario.h"

namespace cdb::compiler {

/// Nullopt after diagnostics. Title and texts of the plan are filled in by `Compile`. `lints`: warn
/// of numbers that Bullet cannot follow (compiler/lints.h), each once with its worst run.
std::optional<plan::Plan> Expand(const scenario::Scenario& scenario,
                                 const scenario::BenchmarkRef& benchmark,
                                 dsl::Diagnostics& diagnostics, bool lints);

}  // namespace cdb::compiler
