// The standard layout of a `.cdb` file (`cdb fmt`).
#pragma once

#include <string>

#include "dsl/text/source.h"

namespace cdb::dsl {

/// The text in the standard layout: two spaces per level; the values of neighbouring settings
/// (those of one benchmark up to a blank line, on all levels) in one column; one space around
/// operators; comments kept; at most one blank line in a row; `;` and line breaks where the author
/// put them; the braces of a block of several lines at the ends of lines. Ends lines with LF.
/// Idempotent, and keeps the syntax tree. The text must parse (see `Parse`); a text that does not
/// is an error of the caller and ends the process.
std::string Format(const text::Source& source);

}  // namespace cdb::dsl
