// Distributions in expressions.
#pragma once

#include <optional>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"
#include "dsl/text/units.h"

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

// Distributions of positive numbers: `lognormal(median: 5 cm, sigma: 0.4)`, `gamma(2, 3)`.

class Evaluator;

/// lognormal, exponential, gamma and weibull, with their arguments by position or by name; nullopt
/// after a diagnostic.
std::optional<schema::Value> EvaluatePositive(const dsl::Expr& call, schema::DistributionKind kind,
                                              const scenario::Scope& scope, Evaluator& evaluator);

// Tables of measured values: `empirical("sizes.csv")`.

class Evaluator;

/// The maximum number of values: each run of a plan stores them.
inline constexpr std::size_t kMaxTableValues = 10000;

/// Reads a table (compiler/plan/text_table.h), whose path is relative to the .cdb file: the columns
/// that the call names, or a column of values, and one of weights. The distribution holds the
/// values, so that a plan needs no file; values with the weight 0 are left out. Nullopt after a
/// diagnostic with the line of the table.
std::optional<schema::Value> EvaluateEmpirical(const dsl::Expr& call, const scenario::Scope& scope,
                                               Evaluator& evaluator);
/// The unit in the heading of the column that the call names, in which the values are read; nullopt
/// if there is none.
std::optional<text::Unit> UnitOfEmpirical(const dsl::Expr& call, const scenario::Scope& scope,
                                          const Evaluator& evaluator);

}  // namespace cdb::evaluate
