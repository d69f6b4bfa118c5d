// Calls in expressions: `sweep(1, 2)`, `uniform(1, 2)`, `ring(radius: 20)`.
#pragma once

#include <optional>

#include "compiler/evaluate/term.h"
#include "compiler/scenario/layers.h"

namespace cdb::evaluate {

class Evaluator;

/// nullopt after a diagnostic.
std::optional<Term> EvaluateCall(const dsl::Expr& call, const scenario::Scope& scope,
                                 Evaluator& evaluator);

}  // namespace cdb::evaluate
