// Settings that are drawn for each object, in the expressions of other settings: `mass 2 * size`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// The value is known only for an object.
bool IsDrawnForEachObject(const schema::Value& value);

/// The setting `key`, which is drawn for each object, as `path` names it: a formula. Nullopt after
/// a diagnostic where it is no number, or not one.
std::optional<schema::Value> NamedSetting(const dsl::Expr& path, const scenario::ParameterKey& key,
                                          const schema::Value& value, Evaluator& evaluator);

/// `arguments`: numbers and formulae. Nullopt after a diagnostic where it has too many parts.
std::optional<schema::Value> MakeFormula(std::string op, std::vector<schema::Value> arguments,
                                         const text::Span& span, Evaluator& evaluator);

/// Reports a formula where a value is needed that all objects share.
void RefuseFormula(const schema::Formula& formula, dsl::Diagnostics& diagnostics);

/// The value that the setting `key` takes: nullopt after a diagnostic where a formula in it names a
/// setting of another group.
std::optional<schema::Value> OfOwnGroup(schema::Value value, const scenario::ParameterKey& key,
                                        Evaluator& evaluator);

}  // namespace cdb::evaluate
