// Calls in expressions: `sweep(1, 2)`, `uniform(1, 2)`, `ring(radius: 20)`.
#pragma once

#include <optional>

#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// Nullopt after a diagnostic.
std::optional<schema::Value> EvaluateCall(const dsl::Expr& call, const scenario::Scope& scope,
                                          Evaluator& evaluator);

/// The arguments of a call, with the defaults of those not given; nullopt after a diagnostic.
std::optional<schema::Call> EvaluateArguments(const dsl::Expr& expr,
                                              const schema::ParametrisedWord& info,
                                              const scenario::Scope& scope, Evaluator& evaluator);

}  // namespace cdb::evaluate
