// Distributions in expressions.
#pragma once

#include <optional>

#include "compiler/evaluate/term.h"
#include "compiler/scenario/layers.h"

namespace cdb::evaluate {

class Evaluator;

/// `any(sphere 3, cone)`; nullopt after a diagnostic.
std::optional<Term> EvaluateAny(const dsl::Expr& call, const scenario::Scope& scope,
                                Evaluator& evaluator);
/// `uniform(1, 2)`, `normal(5, sd: 1)`, `log_uniform(1, 1000)`; nullopt after a diagnostic.
std::optional<Term> EvaluateDistribution(const dsl::Expr& call, schema::DistributionKind kind,
                                         const scenario::Scope& scope, Evaluator& evaluator);

}  // namespace cdb::evaluate
