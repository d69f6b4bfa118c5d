// Arithmetic on terms.
#pragma once

#include <optional>

#include "compiler/evaluate/term.h"
#include "compiler/scenario/layers.h"

namespace cdb::evaluate {

class Evaluator;

/// `-a`; nullopt after a diagnostic.
std::optional<Term> EvaluateNegation(const dsl::Expr& expr, const scenario::Scope& scope,
                                     Evaluator& evaluator);
/// `a + b`, `a - b`, `a * b`, `a / b`, `a ^ b`; nullopt after a diagnostic.
std::optional<Term> EvaluateBinary(const dsl::Expr& expr, const scenario::Scope& scope,
                                   Evaluator& evaluator);

}  // namespace cdb::evaluate
