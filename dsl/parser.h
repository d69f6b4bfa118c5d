// Text to syntax tree.
#pragma once

#include <memory>

#include "dsl/diagnostics.h"
#include "dsl/syntax.h"

namespace cdb::dsl {

/// Blocks, brackets, calls and operators may nest this deep together; past it the text is refused.
inline constexpr int kMaxDepth = 100;

/// Parses a whole file. Every error is reported once and parsing goes on after it, so the tree
/// holds all that could be understood; it must not be compiled when `diagnostics.has_errors()`.
/// Never throws, never recurses past `kMaxDepth`. Source: the grammar in the language reference.
File Parse(std::shared_ptr<const text::Source> source, Diagnostics& diagnostics);

}  // namespace cdb::dsl
