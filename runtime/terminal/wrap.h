// Running text in lines of a terminal's width.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cdb::terminal {

/// Columns for running text: those of the terminal, at most 100; 100 where there is none.
std::size_t TextWidth();

/// Words of `text` in lines of at most `width` columns, each behind `indent` spaces and with a
/// newline. Widths count UTF-8 code points. A word that is wider stands on its own line.
std::string Wrapped(std::string_view text, std::size_t indent, std::size_t width = TextWidth());

/// Tables and paragraphs, laid out for any width, in lines of at most `width` columns; 0 leaves
/// them as they are. The second column of a row goes on below itself, and a paragraph into its next
/// line. A line without a place to break stays long.
std::string Fitted(std::string_view text, std::size_t width);

}  // namespace cdb::terminal
