// Calls in expressions: `sweep(1, 2)`, `uniform(1, 2)`, `ring(radius: 20)`.
#pragma once

#include <optional>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// Nullopt after a diagnostic.
std::optional<schema::Value> EvaluateCall(const dsl::Expr& call, const scenario::Scope& scope,
                                          Evaluator& evaluator);

}  // namespace cdb::evaluate
