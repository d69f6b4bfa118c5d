// A term held against the parameter it is meant for.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/evaluate/term.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"
#include "dsl/diagnostics.h"

namespace cdb::evaluate {

/// The value, or nullopt after a diagnostic at `span` that says what the parameter takes.
/// `choices`: where the choices of an any( ) stand, where that is known. `plugins`: detectors
/// beside the catalogue's.
std::optional<schema::Value> Convert(const Term& term, const schema::Parameter& parameter,
                                     const dsl::Span& span, const std::vector<dsl::Span>& choices,
                                     std::span<const schema::PluginDetector> plugins,
                                     dsl::Diagnostics& diagnostics);

/// `pair` without what it needs: `missing`, of its arguments.
void ReportMissingArguments(const schema::ParametrisedWord& info,
                            const std::vector<std::string_view>& missing, const dsl::Span& span,
                            dsl::Diagnostics& diagnostics);

/// The words of a list parameter (`record timing, counts`).
std::optional<schema::Value> ConvertList(const std::vector<std::pair<Term, dsl::Span>>& terms,
                                         const schema::Parameter& parameter,
                                         dsl::Diagnostics& diagnostics);

}  // namespace cdb::evaluate
