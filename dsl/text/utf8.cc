#include "dsl/text/utf8.h"

namespace cdb::text {

CodePoint DecodeUtf8(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[at + i]); };
  const char32_t first = byte(0);
  if (first < 0x80) return {first, 1};
  // 80 to C1 continue nothing or would be overlong.
  const int bytes = first >= 0xC2 && first < 0xE0   ? 2
                    : first >= 0xE0 && first < 0xF0 ? 3
                    : first >= 0xF0 && first < 0xF5 ? 4
                                                    : 0;
  if (bytes == 0 || text.size() - at < static_cast<std::size_t>(bytes)) return {};
  char32_t value = first & (0x7Fu >> bytes);
  for (int i = 1; i < bytes; ++i) {
    const char32_t next = byte(static_cast<std::size_t>(i));
    if ((next & 0xC0) != 0x80) return {};
    value = (value << 6) | (next & 0x3F);
  }
  const bool overlong = (bytes == 3 && value < 0x800) || (bytes == 4 && value < 0x10000);
  const bool surrogate = value >= 0xD800 && value < 0xE000;
  if (overlong || surrogate || value > 0x10FFFF) return {};
  return {value, bytes};
}

namespace {

bool IsPrintable(char32_t c) {
  return !(c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0x61C || c == 0x200E || c == 0x200F ||
           (c >= 0x2028 && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069));
}

}  // namespace

std::string Printable(std::string_view text) {
  std::string printable;
  for (std::size_t at = 0; at < text.size();) {
    const CodePoint point = DecodeUtf8(text, at);
    const auto bytes = static_cast<std::size_t>(point.bytes > 0 ? point.bytes : 1);
    if (text[at] == '\n' || (point.bytes > 0 && IsPrintable(point.value))) {
      printable += text.substr(at, bytes);
    } else {
      printable.append(bytes, text[at] == '\t' ? ' ' : '?');
    }
    at += bytes;
  }
  return printable;
}

std::string PrintableJson(std::string_view json) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string printable;
  printable.reserve(json.size());
  for (std::size_t at = 0; at < json.size();) {
    const CodePoint point = DecodeUtf8(json, at);
    const auto bytes = static_cast<std::size_t>(point.bytes > 0 ? point.bytes : 1);
    if (point.bytes == 0 || point.value < 0x20 || IsPrintable(point.value)) {
      printable += json.substr(at, bytes);
    } else {  // all of them have at most four digits
      printable += "\\u";
      for (int shift = 12; shift >= 0; shift -= 4) printable += kDigits[point.value >> shift & 0xF];
    }
    at += bytes;
  }
  return printable;
}

int ColumnsOf(char32_t value) {
  struct Range {
    char32_t first, last;
  };
  // Deliberately coarse: the blocks that terminals draw wide, and the combining marks.
  static constexpr Range kCombining[] = {
      {0x300, 0x36F}, {0x200B, 0x200D}, {0x20D0, 0x20FF}, {0xFE00, 0xFE0F}, {0xFE20, 0xFE2F}};
  static constexpr Range kWide[] = {{0x1100, 0x115F},   {0x2E80, 0x303E},  {0x3041, 0xA4CF},
                                    {0xAC00, 0xD7A3},   {0xF900, 0xFAFF},  {0xFE30, 0xFE6F},
                                    {0xFF00, 0xFF60},   {0xFFE0, 0xFFE6},  {0x1F300, 0x1F64F},
                                    {0x1F900, 0x1F9FF}, {0x20000, 0x3FFFD}};
  if (value < 0x300) return 1;
  for (const Range& range : kCombining)
    if (value >= range.first && value <= range.last) return 0;
  for (const Range& range : kWide)
    if (value >= range.first && value <= range.last) return 2;
  return 1;
}

}  // namespace cdb::text
