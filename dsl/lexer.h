// The lexer: source text to tokens.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/text/source.h"

namespace cdb::dsl {

enum class TokenKind : std::uint8_t {
  kEnd,
  kNewline,  ///< one or more line ends, where a statement can end
  kSemicolon,
  kPath,  ///< a name or a dotted path, also a word such as `step` or `and`
  kNumber,
  kText,  ///< including its quotes
  kLeftBrace,
  kRightBrace,
  kLeftParen,
  kRightParen,
  kLeftBracket,
  kRightBracket,
  kComma,
  kColon,
  kDots,
  kPlus,
  kMinus,
  kStar,
  kSlash,
  kCaret,
  kAssign,
  kEqual,
  kNotEqual,
  kLess,
  kLessEqual,
  kGreater,
  kGreaterEqual,
  kAnd,      ///< `&&`; the word `and` is a kPath
  kOr,       ///< `||`
  kNot,      ///< `!`
  kUnknown,  ///< a character without a meaning
};

struct Token {
  TokenKind kind = TokenKind::kEnd;
  bool faulty = false;  ///< already reported, so that it is not reported again
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

struct TokenList {
  std::vector<Token> tokens;         ///< ends with kEnd
  std::vector<text::Span> comments;  ///< `#` to the end of its line, without trailing spaces
};

/// Reports every lexical error. Line ends after `(` and `,` and before `)` and `]` give no tokens.
/// A text that is not UTF-8 or contains a NUL is rejected as a whole: one error, and only kEnd.
TokenList Lex(const text::Source& source, Diagnostics& diagnostics);

/// The contents of a kText token with escapes resolved; of a faulty token, the readable part.
std::string TextContents(std::string_view lexeme);

// Number literals: their form and range.

/// False, with one report at `span`, if the lexeme is not a number of the language or does not fit
/// into 64 bits.
bool CheckNumber(std::string_view lexeme, const text::Span& span, Diagnostics& diagnostics);

}  // namespace cdb::dsl
