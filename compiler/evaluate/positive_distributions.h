// Distributions of positive numbers: `lognormal(median: 5 cm, sigma: 0.4)`, `gamma(2, 3)`.
#pragma once

#include <optional>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// lognormal, exponential, gamma and weibull, with their arguments by position or by name; nullopt
/// after a diagnostic.
std::optional<schema::Value> EvaluatePositive(const dsl::Expr& call, schema::DistributionKind kind,
                                              const scenario::Scope& scope, Evaluator& evaluator);

}  // namespace cdb::evaluate
