// Conversion of a value to the type of a parameter.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"
#include "dsl/diagnostics.h"

namespace cdb::evaluate {

/// The setting made from `value`: a count, a real, a switch; each choice of an any( ) is converted.
/// Nullopt after a diagnostic at `span` that states the values the parameter takes. `choices`: the
/// locations of those choices, if known. `plugins`: detectors besides the catalogue's.
std::optional<schema::Value> Convert(const schema::Value& value, const schema::Parameter& parameter,
                                     const text::Span& span, const std::vector<text::Span>& choices,
                                     std::span<const schema::PluginDetector> plugins,
                                     dsl::Diagnostics& diagnostics);

/// Reports that `missing` arguments of the word `info` are missing.
void ReportMissingArguments(const schema::ParametrisedWord& info,
                            const std::vector<std::string_view>& missing, const text::Span& span,
                            dsl::Diagnostics& diagnostics);

/// The words of a list parameter (`record timing, counts`).
std::optional<schema::Value> ConvertList(
    const std::vector<std::pair<schema::Value, text::Span>>& values,
    const schema::Parameter& parameter, dsl::Diagnostics& diagnostics);

// Settings that are drawn for each object, in the expressions of other settings: `mass 2 * size`.

class Evaluator;

/// True if the value is known only for a given object.
bool IsDrawnForEachObject(const schema::Value& value);

/// A variable of the formula that a parameter takes (Parameter::is_formula).
schema::Value Variable(const dsl::Expr& path);

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
