// The answers of the server about a position in a text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/editor/documents.h"

namespace cdb::editor {

/// Diagnostics of the document, in the form of the protocol. An error in another file is shown at
/// the `use` that reads it.
Json DiagnosticsOf(const Analysis& analysis);

/// The manual entry of the word at the position; null if there is none.
Json HoverAt(const Analysis& analysis, std::uint32_t offset);

/// The definition of the name, or the file of a `use`; null if there is none.
Json DefinitionOf(const Analysis& analysis, const std::string& path, std::uint32_t offset,
                  const std::string& library);
/// All occurrences of the name at this position.
Json ReferencesTo(const Analysis& analysis, std::uint32_t offset);

/// The number of runs behind the name of each benchmark; empty while there are errors.
Json InlayHints(const Analysis& analysis);

/// Benchmarks with their groups and lets.
Json SymbolsOf(const Analysis& analysis);

}  // namespace cdb::editor
