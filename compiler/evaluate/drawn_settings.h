// Settings that are drawn for each object, in the expressions of other settings: `mass 2 * size`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// True if the value is known only for a given object.
bool IsDrawnForEachObject(const schema::Value& value);

/// The setting `key`, drawn for each object and named by `path`, as a formula. Nullopt after a
/// diagnostic if it is not a single number.
std::optional<schema::Value> NamedSetting(const dsl::Expr& path, const scenario::ParameterKey& key,
                                          const schema::Value& value, Evaluator& evaluator);

/// `arguments`: numbers and formulae. Nullopt after a diagnostic if the formula has too many parts.
std::optional<schema::Value> MakeFormula(std::string op, std::vector<schema::Value> arguments,
                                         const text::Span& span, Evaluator& evaluator);

/// Reports a formula where all objects must share one value.
void RefuseFormula(const schema::Formula& formula, dsl::Diagnostics& diagnostics);

/// The value that the setting `key` takes. Nullopt after a diagnostic if a formula in it names a
/// setting of another group.
std::optional<schema::Value> OfOwnGroup(schema::Value value, const scenario::ParameterKey& key,
                                        Evaluator& evaluator);

}  // namespace cdb::evaluate
