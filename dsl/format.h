// The one way a `.cdb` file is laid out (`cdb fmt`).
#pragma once

#include <string>

#include "dsl/text/source.h"

namespace cdb::dsl {

/// The text in the standard layout: two spaces a level, values of neighbouring settings (those of
/// one benchmark up to a blank line, on all levels) in one column, one space around operators,
/// comments kept, at most one blank line in a row, `;` and line breaks where the author put them; a
/// block of several lines has its braces at the ends of lines. Ends lines with LF. Idempotent, and
/// the tree does not change. The text has to parse (see `Parse`): a text that does not is the
/// caller's mistake and ends the process.
std::string Format(const text::Source& source);

}  // namespace cdb::dsl
