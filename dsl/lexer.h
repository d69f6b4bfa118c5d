// Text to tokens.
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
  kNewline,  ///< one or more line ends where a statement can end there
  kSemicolon,
  kPath,  ///< a name or a dotted path; words such as `step` and `and` too
  kNumber,
  kText,  ///< with its quotes
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
  kAnd,      ///< `&&`; the word is a kPath
  kOr,       ///< `||`
  kNot,      ///< `!`
  kUnknown,  ///< a character that means nothing
};

struct Token {
  TokenKind kind = TokenKind::kEnd;
  bool faulty = false;  ///< already reported, so that nobody complains a second time
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

struct TokenList {
  std::vector<Token> tokens;         ///< ends with kEnd
  std::vector<text::Span> comments;  ///< `#` to the end of its line, without trailing spaces
};

/// Reports every lexical error. Line ends after `(` and `,` and before `)` and `]` are no tokens.
/// A text that is not UTF-8 or holds a NUL is refused whole: one error, and only kEnd.
TokenList Lex(const text::Source& source, Diagnostics& diagnostics);

/// The contents of a kText token with its escapes resolved; a faulty one gives what can be read.
std::string TextContents(std::string_view lexeme);

}  // namespace cdb::dsl
