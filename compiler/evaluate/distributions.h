// Distributions in expressions.
#pragma once

#include <optional>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// `any(sphere 3, cone)`; nullopt after a diagnostic.
std::optional<schema::Value> EvaluateAny(const dsl::Expr& call, const scenario::Scope& scope,
                                         Evaluator& evaluator);
/// `normal(5, sd: 1)`, `log_uniform(1, 1000)`, `gamma(2, 3) in 1 .. 9`; nullopt after a diagnostic.
std::optional<schema::Value> EvaluateDistribution(const dsl::Expr& call,
                                                  schema::DistributionKind kind,
                                                  const scenario::Scope& scope,
                                                  Evaluator& evaluator);

}  // namespace cdb::evaluate
