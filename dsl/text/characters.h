// Classes of characters in the source.
#pragma once

#include <string_view>

namespace cdb::text {

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
