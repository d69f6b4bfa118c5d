// Functions of numbers: `round(1.5 * n)`, `sqrt(2)`.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// `round floor ceil abs min max sqrt sin cos exp log`. They are not reserved: a let may have such
/// a name.
std::vector<std::string_view> FunctionNames();
bool IsFunction(std::string_view name);

/// The constant `pi`, unless a let has this name.
inline constexpr std::string_view kPiName = "pi";
inline constexpr double kPi = 3.141592653589793;

/// `round floor ceil` give integers, with halves rounded away from zero; `abs min max` of integers
/// are integers; the others give reals as rounded by the C library, which the plan then stores.
/// Values drawn for each object give a formula. Nullopt after a diagnostic.
std::optional<schema::Value> EvaluateFunction(const dsl::Expr& call, const scenario::Scope& scope,
                                              Evaluator& evaluator);

}  // namespace cdb::evaluate
