// Functions of numbers: `round(1.5 * n)`, `sqrt(2)`.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// `round floor ceil abs min max sqrt sin cos exp log`. They are no reserved words: a let may have
/// such a name.
std::vector<std::string_view> FunctionNames();
bool IsFunction(std::string_view name);

/// The constant that `pi` is where no let has the name.
inline constexpr std::string_view kPiName = "pi";
inline constexpr double kPi = 3.141592653589793;

/// `round floor ceil` give whole numbers, halves away from zero; `abs min max` keep whole numbers
/// whole; the others give reals as the C library rounds them, which the plan then holds. Of values
/// that are drawn for each object, a formula. Nullopt after a diagnostic.
std::optional<schema::Value> EvaluateFunction(const dsl::Expr& call, const scenario::Scope& scope,
                                              Evaluator& evaluator);

}  // namespace cdb::evaluate
