// The parser: source text to syntax tree.
#pragma once

#include <memory>

#include "dsl/diagnostics.h"
#include "dsl/syntax.h"

namespace cdb::dsl {

/// The maximum depth of nested blocks, brackets, calls and operators together; deeper is an error.
inline constexpr int kMaxDepth = 100;

/// Parses a whole file. Every error is reported once, and parsing goes on after it, so the tree
/// holds everything that could be parsed; it must not be compiled if `diagnostics.has_errors()`.
/// Never throws, never recurses deeper than `kMaxDepth`. Source: the grammar in the language
/// reference.
File Parse(std::shared_ptr<const text::Source> source, Diagnostics& diagnostics);

}  // namespace cdb::dsl
