// Conversion of a value to the type of a parameter.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

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

}  // namespace cdb::evaluate
