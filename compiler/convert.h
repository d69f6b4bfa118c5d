// A term held against the parameter it is meant for.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/calls.h"
#include "compiler/schema.h"
#include "compiler/term.h"
#include "compiler/value.h"
#include "dsl/diagnostics.h"

namespace cdb::compiler {

/// The value, or nullopt after a diagnostic at `span` that says what the parameter takes.
/// `choices`: where the choices of an any( ) stand, where that is known. `plugins`: detectors
/// beside the catalogue's.
std::optional<Value> Convert(const Term& term, const Parameter& parameter, const dsl::Span& span,
                             const std::vector<dsl::Span>& choices,
                             std::span<const PluginDetector> plugins,
                             dsl::Diagnostics& diagnostics);

/// `pair` without what it needs: `missing`, of its arguments.
void ReportMissingArguments(const CallInfo& info, const std::vector<std::string_view>& missing,
                            const dsl::Span& span, dsl::Diagnostics& diagnostics);

/// The words of a list parameter (`record timing, counts`).
std::optional<Value> ConvertList(const std::vector<std::pair<Term, dsl::Span>>& terms,
                                 const Parameter& parameter, dsl::Diagnostics& diagnostics);

}  // namespace cdb::compiler
