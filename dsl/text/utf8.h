// Decodes UTF-8, and makes text safe to print.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cdb::text {

struct CodePoint {
  char32_t value = 0;
  int bytes = 0;  ///< 1 to 4; 0 if the text is not UTF-8 at this byte
};

/// Decodes the code point at `at`, which must be inside the text. Overlong forms, surrogates and
/// values above U+10FFFF are not UTF-8.
CodePoint DecodeUtf8(std::string_view text, std::size_t at);

/// Makes a text from outside safe to store and print: `?` replaces each byte that is not UTF-8, of
/// a control character other than a line feed, or of a mark that changes the direction of text; a
/// space replaces a tab.
std::string Printable(std::string_view text);

/// JSON with escapes for the characters in its strings that Printable replaces. JSON itself has
/// them for control characters below a space alone.
std::string PrintableJson(std::string_view json);

/// The width in columns of a terminal: 0 (combining), 1 or 2 (wide).
int ColumnsOf(char32_t value);

// Classes of characters in the source.

inline bool IsDigit(char c) { return c >= '0' && c <= '9'; }
inline bool IsHexDigit(char c) {
  return IsDigit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}
inline bool IsLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
inline bool IsNameChar(char c) { return IsLetter(c) || IsDigit(c); }
/// A name in the sense of the language: of a benchmark, a group or a let.
inline bool IsPlainName(std::string_view text) {
  if (text.empty() || !IsLetter(text[0])) return false;
  for (const char c : text)
    if (!IsNameChar(c)) return false;
  return true;
}
inline bool IsControl(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 0x20 && c != '\t') || byte == 0x7F;
}

}  // namespace cdb::text
