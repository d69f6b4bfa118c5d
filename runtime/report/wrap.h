// Running text in lines of a terminal's width.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cdb::report {

/// Columns for running text: those of the terminal, at most 100; 100 where there is none.
std::size_t TextWidth();

/// Words of `text` in lines of at most `width` columns, each behind `indent` spaces and with a
/// newline. Widths count UTF-8 code points. A word that is wider stands on its own line.
std::string Wrapped(std::string_view text, std::size_t indent, std::size_t width = TextWidth());

}  // namespace cdb::report
