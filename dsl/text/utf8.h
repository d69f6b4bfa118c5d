// One code point of a UTF-8 text.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cdb::text {

struct CodePoint {
  char32_t value = 0;
  int bytes = 0;  ///< 1 to 4; 0 where the text is not UTF-8 at that byte
};

/// Decodes at `at`, which has to be inside the text. Overlong forms, surrogates and values past
/// U+10FFFF are not UTF-8.
CodePoint DecodeUtf8(std::string_view text, std::size_t at);

/// A text from elsewhere, fit to be stored and printed: each byte that is not UTF-8, of a control
/// character other than a line feed, or of a mark that turns the direction of text, becomes `?`,
/// and a tab a space.
std::string Printable(std::string_view text);

/// How many columns of a terminal it takes: 0 (combining), 1 or 2 (wide).
int ColumnsOf(char32_t value);

}  // namespace cdb::text
