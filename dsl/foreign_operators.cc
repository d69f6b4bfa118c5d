#include "dsl/foreign_operators.h"

#include <algorithm>

namespace cdb::dsl {
namespace {

// An operator that begins with another one stands before it.
constexpr ForeignOperator kForeignOperators[] = {
    {"===", TokenKind::kEqual, "=="},
    {"!==", TokenKind::kNotEqual, "!="},
    {"=>", TokenKind::kGreaterEqual, ">="},
    {"=<", TokenKind::kLessEqual, "<="},
    {"<>", TokenKind::kNotEqual, "!="},
    {":=", TokenKind::kAssign, "="},
    {"**", TokenKind::kCaret, "^"},
    {"&&", TokenKind::kAnd, "and"},
    {"||", TokenKind::kOr, "or"},
    {"&", TokenKind::kAnd, "and"},
    {"|", TokenKind::kOr, "or"},
    {"\u2212", TokenKind::kMinus, "-"},
    {"\u2013", TokenKind::kMinus, "-"},
    {"\u2014", TokenKind::kMinus, "-"},
    {"\u00D7", TokenKind::kStar, "*"},
    {"\u00B7", TokenKind::kStar, "*"},
    {"\u00F7", TokenKind::kSlash, "/"},
    {"\u2026", TokenKind::kDots, ".."},
    {"\u2264", TokenKind::kLessEqual, "<="},
    {"\u2265", TokenKind::kGreaterEqual, ">="},
    {"\u2260", TokenKind::kNotEqual, "!="},
};

}  // namespace

const ForeignOperator* FindForeignOperator(std::string_view text) {
  for (const ForeignOperator& foreign : kForeignOperators)
    if (text.starts_with(foreign.text)) return &foreign;
  return nullptr;
}

std::size_t ForeignTextBytes(std::string_view text, std::size_t& quote_bytes) {
  for (const std::string_view quote :
       {"\u201C", "\u201D", "\u201E", "\u00AB", "\u2018", "\u2019"}) {
    if (!text.starts_with(quote)) continue;
    quote_bytes = quote.size();
    const std::size_t line_end = std::min(text.find_first_of("\r\n"), text.size());
    std::size_t close = line_end, end = quote.size();
    for (const std::string_view last : {"\u201D", "\u201C", "\u00BB", "\u2019", "\""}) {
      const std::size_t at = text.find(last, end);
      if (at < close) {
        close = at;
        end = at + last.size();
      }
    }
    return close == line_end ? line_end : end;
  }
  return 0;
}

}  // namespace cdb::dsl
