// The words that are allowed at a position of a text, whether or not the text around it parses.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "dsl/text/source.h"
#include "runtime/editor/documents.h"

namespace cdb::editor {

enum class Expected {
  kNothing,    ///< in a comment, or for a new name
  kItem,       ///< at file level: use, let, benchmark
  kStatement,  ///< in a block
  kValue,      ///< of `parameter`, or of a let
  kCondition,  ///< after `skip when`
  kBase,       ///< a benchmark, after `from`
  kFile,       ///< after `use`
};

struct Context {
  Expected expected = Expected::kNothing;
  std::uint32_t begin = 0, end = 0;                ///< the word or the text at the position
  std::string prefix;                              ///< its part before the position
  std::string group, block;                        ///< as in scenario::Scope
  bool is_grouped = false;                         ///< inside objects { }
  const schema::Parameter* parameter = nullptr;    ///< that is being set or compared
  const schema::ParametrisedWord* word = nullptr;  ///< whose arguments are being written
};

/// The context at the byte `offset`.
Context ContextAt(const text::Source& source, std::uint32_t offset);

/// The parameter that a path names in a block; null if there is none.
const schema::Parameter* ParameterAt(const Context& context, const std::string& path);

// The answers of the server about a position in a text.

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

/// The plan of a benchmark, with its first runs only; nullopt if there are errors, or `skip` skips
/// those runs.
std::optional<plan::Plan> FirstRunOf(const Analysis& analysis, const std::string& benchmark);

/// Benchmarks with their groups and lets.
Json SymbolsOf(const Analysis& analysis);

}  // namespace cdb::editor
