// Wraps running text to the width of a terminal.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cdb::terminal {

/// Columns for running text: those of the terminal, at most 100; 100 if there is no terminal.
std::size_t TextWidth();

/// The words of `text` in lines of at most `width` columns, each after `indent` spaces and with a
/// newline. Widths count UTF-8 code points. A wider word has its own line.
std::string Wrapped(std::string_view text, std::size_t indent, std::size_t width = TextWidth());

/// Refits tables and paragraphs of any width into lines of at most `width` columns; 0 leaves them
/// unchanged. The second column of a row continues below itself, and a paragraph on its next line.
/// A line that cannot be broken stays long.
std::string Fitted(std::string_view text, std::size_t width);

}  // namespace cdb::terminal
