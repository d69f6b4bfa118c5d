// The numbers of a range: `1 .. 5`, `0 .. 1 step 0.1`, `1 .. 1000 count 4 log`.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// The maximum number of values on one axis.
inline constexpr std::size_t kMaxAxisValues = 1'000'000;

/// Nullopt after a diagnostic.
std::optional<std::vector<schema::Number>> ExpandRange(const dsl::Expr& range,
                                                       const scenario::Scope& scope,
                                                       Evaluator& evaluator);

/// Rounds the numbers between the ends of a logarithmic range to integers, and removes duplicates:
/// a count cannot be 34.66.
void RoundBetweenEnds(std::vector<schema::Number>& numbers);

}  // namespace cdb::evaluate
