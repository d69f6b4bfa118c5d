// Parses blocks and their braces, and finds the point at which to go on after an error.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/statement_parser.h"
#include "dsl/text/concat.h"

namespace cdb::dsl {

std::uint32_t StatementParser::IndentAt(std::uint32_t offset) const {
  const text::Source& source = cursor_.source();
  const std::uint32_t begin = source.LineStart(source.PositionAt(offset).line);
  const std::size_t first = source.text().find_first_not_of(" \t", begin);
  return static_cast<std::uint32_t>(first) - begin;
}

bool StatementParser::AtFileItem() const {
  const Token& token = cursor_.Peek();
  return (cursor_.AtWord("benchmark") || cursor_.AtWord("use")) && IndentAt(token.begin) == 0 &&
         cursor_.FirstOnLine(token);
}

void StatementParser::ReportUnclosed() {
  AddDamage(Damage::kMisnested);
  if (unclosed_reported_) return;
  unclosed_reported_ = true;
  const Token& found = cursor_.Peek();
  std::vector<Note> notes;
  text::Span brace = open_.back().brace;
  if (suspect_) {
    brace = *suspect_;
  } else {
    for (std::size_t i = open_.size() - 1; i-- > 0;)
      notes.push_back({open_[i].brace, "this '{' is not closed either"});
  }
  notes.push_back({cursor_.SpanOf(found),
                   found.kind == TokenKind::kEnd
                       ? "the file ends here"
                       : cursor_.Quote(found) + " begins here, which must be outside blocks"});
  cursor_.Report(kUnclosedBlock, brace, "this '{' has no '}'", "", std::move(notes));
}

bool StatementParser::ParseBraces(text::Span& span, const text::Span& owner,
                                  const std::function<void()>& parse_one) {
  if (cursor_.At(TokenKind::kNewline) && cursor_.Peek(1).kind == TokenKind::kLeftBrace) {
    cursor_.Take();
    cursor_.Report(kBraceOnOwnLine, cursor_.SpanOf(cursor_.Peek()),
                   "a block begins on the line of its name",
                   "put the '{' at the end of the line above");
  }
  // Lines indented further form the block, although its '{' is missing.
  const bool brace_missing = cursor_.At(TokenKind::kNewline) &&
                             cursor_.Peek(1).kind == TokenKind::kPath &&
                             IndentAt(cursor_.Peek(1).begin) > IndentAt(owner.begin);
  if (brace_missing) {
    cursor_.Report(kMissingBlock, owner, "this has no '{'", "write it at the end of the line");
  } else if (!cursor_.At(TokenKind::kLeftBrace)) {
    if (cursor_.AtStatementEnd()) {
      cursor_.Report(kMissingBlock, owner, "this has no block", "write { … } after it");
      return false;
    }
    cursor_.ReportUnexpected("'{'");
    while (!cursor_.AtStatementEnd() && !cursor_.At(TokenKind::kLeftBrace)) cursor_.Take();
    if (!cursor_.At(TokenKind::kLeftBrace)) return false;
  }
  const DepthScope deeper(cursor_);
  const Token brace = cursor_.Peek();
  if (!cursor_.FitsDepth(0, cursor_.SpanOf(brace))) {
    SkipBraces();
    return false;
  }
  cursor_.Take();
  open_.push_back({brace_missing ? owner : cursor_.SpanOf(brace), IndentAt(owner.begin)});
  while (true) {
    SkipEmpty();
    if (cursor_.At(TokenKind::kRightBrace)) {
      const Token close = cursor_.Take();
      if (!suspect_ && cursor_.FirstOnLine(close) && IndentAt(close.begin) < open_.back().indent)
        suspect_ = open_.back().brace;
      break;
    }
    if (cursor_.At(TokenKind::kEnd) || AtFileItem()) {
      ReportUnclosed();
      break;
    }
    parse_one();
  }
  open_.pop_back();
  span = cursor_.SpanFrom(brace.begin);
  return true;
}

bool StatementParser::ParseBlock(Block& block, const text::Span& owner) {
  return ParseBraces(block.span, owner, [&] { ParseStatement(block.statements); });
}

// Skips from a '{' past its '}' without reading the contents.
void StatementParser::SkipBraces() {
  int depth = 0;
  while (!cursor_.At(TokenKind::kEnd)) {
    const TokenKind kind = cursor_.Take().kind;
    if (kind == TokenKind::kLeftBrace) ++depth;
    if (kind == TokenKind::kRightBrace && --depth == 0) return;
  }
}

// True at `{1, 2, 3}` or `{a, b}`, which other languages use for a vector or a list.
bool StatementParser::ListInBraces() const {
  switch (cursor_.Peek(1).kind) {
    case TokenKind::kNumber:
    case TokenKind::kMinus:
    case TokenKind::kLeftParen:
    case TokenKind::kText:
      return true;
    case TokenKind::kPath:
      return cursor_.Peek(2).kind == TokenKind::kComma;
    default:
      return false;
  }
}

void StatementParser::EndStatement() {
  if (std::exchange(statement_begins_, false)) return;
  if (cursor_.AtStatementEnd() || cursor_.Previous().kind == TokenKind::kRightBrace) return;
  // A block left open ends where the next item of the file begins.
  if (AtFileItem()) return;
  const Token token = cursor_.Peek();
  if (token.kind == TokenKind::kRightParen || token.kind == TokenKind::kRightBracket) {
    ReportStrayBracket();
  } else if (cursor_.AtWord("as")) {
    values_.ReportMisplacedAs();
  } else {
    cursor_.ReportUnexpected("the end of the statement",
                             token.kind == TokenKind::kPath ? "a ';' ends it too" : "");
  }
  SkipStatement();
}

void StatementParser::ReportStrayBracket() {
  const Token& token = cursor_.Peek();
  cursor_.Report(kStrayBracket, cursor_.SpanOf(token),
                 text::Concat({"this ", cursor_.Quote(token), " does not close any parenthesis"}));
}

void StatementParser::SkipStatement() {
  while (!cursor_.AtStatementEnd()) {
    if (cursor_.At(TokenKind::kLeftBrace)) {
      AddDamage(Damage::kLost);
      Block dropped;
      ParseBlock(dropped, cursor_.SpanOf(cursor_.Peek()));
      return;
    }
    cursor_.Take();
  }
}

}  // namespace cdb::dsl
