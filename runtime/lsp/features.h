// What the server answers about a place of a text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/lsp/documents.h"

namespace cdb::lsp {

/// Of the document's text, as the protocol lists them. What is wrong in another file stands at the
/// `use` that reads it.
Json DiagnosticsOf(const Analysis& analysis);

/// What the manual says of the word at the place; null where there is none.
Json HoverAt(const Analysis& analysis, std::uint32_t offset);

/// Where the name, or the file of a `use`, is defined; null where it is not.
Json DefinitionOf(const Analysis& analysis, const std::string& path, std::uint32_t offset,
                  const std::string& library);
/// Every place of the name at this place.
Json ReferencesTo(const Analysis& analysis, std::uint32_t offset);

/// The number of runs behind the name of each benchmark; nothing while there are errors.
Json InlayHints(const Analysis& analysis);

/// Benchmarks, their groups and lets.
Json SymbolsOf(const Analysis& analysis);

}  // namespace cdb::lsp
