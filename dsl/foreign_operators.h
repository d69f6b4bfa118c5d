// Operators and quotes of other languages, word processors and keyboards.
#pragma once

#include <string_view>

#include "dsl/lexer.h"

namespace cdb::dsl {

struct ForeignOperator {
  std::string_view text;
  TokenKind kind;
  std::string_view here;  ///< its spelling in this language
};

/// The foreign operator at the start of `text`; null if there is none.
const ForeignOperator* FindForeignOperator(std::string_view text);

/// The length in bytes of a text in typographic quotes (“…”, „…“, «…») at the start of `text`, up
/// to the end of its line if it is not closed; 0 if there is none. `quote_bytes` receives the
/// length of the opening quote.
std::size_t ForeignTextBytes(std::string_view text, std::size_t& quote_bytes);

}  // namespace cdb::dsl
