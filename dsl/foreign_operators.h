// Operators and quotes that other languages, word processors and keyboards write.
#pragma once

#include <string_view>

#include "dsl/lexer.h"

namespace cdb::dsl {

struct ForeignOperator {
  std::string_view text;
  TokenKind kind;
  std::string_view here;  ///< how it is written here
};

/// The one that `text` begins with; null if none.
const ForeignOperator* FindForeignOperator(std::string_view text);

/// The bytes of a text in typographic quotes (“…”, „…“, «…») at the start of `text`, up to the end
/// of its line if it is not closed; 0 if there is none. `quote_bytes`: of the opening quote.
std::size_t ForeignTextBytes(std::string_view text, std::size_t& quote_bytes);

}  // namespace cdb::dsl
