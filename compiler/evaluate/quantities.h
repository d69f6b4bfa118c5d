// Values with units: `10 ms` is the number 0.01.
#pragma once

#include <optional>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"
#include "dsl/text/units.h"

namespace cdb::evaluate {

class Evaluator;

/// The number in SI units. The shortest decimal text of `number` is scaled exactly and rounded
/// once, so that `10 ms` is the same double as 0.01. A factor of pi or a divisor (km/h) adds one
/// rounding, and an angle in degrees is within an ulp. Not finite if it does not fit.
schema::Number InSi(const schema::Number& number, const text::Unit& unit);

/// `5 cm`, `(1, 2, 3) cm`, `uniform(1, 5) cm`; nullopt after a diagnostic.
std::optional<schema::Value> EvaluateQuantity(const dsl::Expr& expr, const scenario::Scope& scope,
                                              Evaluator& evaluator);

}  // namespace cdb::evaluate
