// Tables of measured values: `empirical("sizes.csv")`.
#pragma once

#include <optional>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// The maximum number of values: each run of a plan stores them.
inline constexpr std::size_t kMaxTableValues = 10000;

/// Reads a table, whose path is relative to the .cdb file: one value per line, or a value and its
/// weight separated by a comma. The first line may be a heading; `#` begins a comment. The
/// distribution holds the values, so that a plan needs no file. Nullopt after a diagnostic with the
/// line of the table.
std::optional<schema::Value> EvaluateEmpirical(const dsl::Expr& call, Evaluator& evaluator);

}  // namespace cdb::evaluate
