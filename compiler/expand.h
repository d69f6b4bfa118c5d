// A benchmark to its plan: every point of the grid, with all settings as values.
#pragma once

#include <optional>

#include "compiler/plan.h"
#include "compiler/scenario.h"

namespace cdb::compiler {

/// Nullopt after diagnostics. Title and texts of the plan are filled in by `Compile`. `lints`: warn
/// of numbers that Bullet cannot follow (compiler/lints.h), each once with its worst run.
std::optional<Plan> Expand(const Scenario& scenario, const BenchmarkRef& benchmark,
                           dsl::Diagnostics& diagnostics, bool lints);

}  // namespace cdb::compiler
