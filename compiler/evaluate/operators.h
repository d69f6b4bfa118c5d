// Arithmetic on values.
#pragma once

#include <optional>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// `-a`; nullopt after a diagnostic.
std::optional<schema::Value> EvaluateNegation(const dsl::Expr& expr, const scenario::Scope& scope,
                                              Evaluator& evaluator);
/// `a + b`, `a - b`, `a * b`, `a / b`, `a ^ b`; nullopt after a diagnostic.
std::optional<schema::Value> EvaluateBinary(const dsl::Expr& expr, const scenario::Scope& scope,
                                            Evaluator& evaluator);

}  // namespace cdb::evaluate
