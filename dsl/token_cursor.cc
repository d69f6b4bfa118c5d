#include "dsl/token_cursor.h"

#include <algorithm>

#include "dsl/diagnostics.h"
#include "dsl/parser.h"
#include "dsl/text/concat.h"

namespace cdb::dsl {
namespace {

constexpr std::size_t kLongestQuote = 40;

// Shortens a text for a message: one line, not too long, cut between characters.
std::string Shorten(std::string_view text) {
  std::string shown(text.substr(0, text.find_first_of("\r\n")));
  if (shown.size() > kLongestQuote) {
    std::size_t cut = kLongestQuote;
    while (cut > 0 && (static_cast<unsigned char>(shown[cut]) & 0xC0) == 0x80) --cut;
    shown.resize(cut);
  }
  const bool cut = shown.size() < text.size();
  return cut ? shown + "…" : shown;
}

}  // namespace

bool IsReserved(std::string_view word) {
  return word == "benchmark" || word == "use" || word == "let" || word == "cases" || word == "skip";
}

TokenCursor::TokenCursor(const text::Source& source, Diagnostics& diagnostics)
    : source_(source), diagnostics_(diagnostics), tokens_(Lex(source, diagnostics).tokens) {
  int faulty = 0;
  for (const Token& token : tokens_) {
    faulty_before_.push_back(faulty);
    faulty += token.faulty;
  }
}

const Token& TokenCursor::Peek(std::size_t ahead) const {
  return tokens_[std::min(index_ + ahead, tokens_.size() - 1)];
}

const Token& TokenCursor::Previous() const {
  static constexpr Token kNone;
  return index_ == 0 ? kNone : tokens_[index_ - 1];
}

Token TokenCursor::Take() {
  const Token token = Peek();
  if (token.kind != TokenKind::kEnd) ++index_;
  return token;
}

bool TokenCursor::AtWord(std::string_view word, std::size_t ahead) const {
  return Peek(ahead).kind == TokenKind::kPath && Text(Peek(ahead)) == word;
}

std::string TokenCursor::Excerpt(const text::Span& span) const {
  constexpr std::size_t kLongest = 60;
  const std::string_view text = text::TextOf(span);
  return text.size() > kLongest || text.find_first_of("\r\n") != text.npos ? "…"
                                                                           : std::string(text);
}

bool TokenCursor::AtStatementEnd(std::size_t ahead) const {
  const TokenKind kind = Peek(ahead).kind;
  return kind == TokenKind::kNewline || kind == TokenKind::kSemicolon ||
         kind == TokenKind::kRightBrace || kind == TokenKind::kEnd;
}

bool TokenCursor::AtValueStart(std::size_t ahead) const {
  switch (Peek(ahead).kind) {
    case TokenKind::kPath:
    case TokenKind::kNumber:
    case TokenKind::kText:
    case TokenKind::kLeftParen:
    case TokenKind::kLeftBracket:
      return true;
    default:
      return false;
  }
}

bool TokenCursor::NextLineContinues() const {
  if (!At(TokenKind::kNewline)) return false;
  switch (Peek(1).kind) {
    case TokenKind::kNumber:
    case TokenKind::kText:
    case TokenKind::kLeftParen:
    case TokenKind::kComma:
    case TokenKind::kColon:
    case TokenKind::kDots:
    case TokenKind::kPlus:
    case TokenKind::kMinus:
    case TokenKind::kStar:
    case TokenKind::kSlash:
    case TokenKind::kCaret:
      return true;
    case TokenKind::kPath:
      // `name value` is a separate statement, and so is `name -1`, with no space after the sign.
      if (Peek(2).kind == TokenKind::kMinus && Peek(2).begin > Peek(1).end &&
          Peek(3).begin == Peek(2).end)
        return false;
      return !AtValueStart(2) && Peek(2).kind != TokenKind::kLeftBrace &&
             Peek(2).kind != TokenKind::kAssign && !IsReserved(Text(Peek(1)));
    default:
      return false;
  }
}

bool TokenCursor::FirstOnLine(const Token& token) const {
  const std::uint32_t begin = source_.LineStart(source_.PositionAt(token.begin).line);
  const std::string_view before = source_.text().substr(begin, token.begin - begin);
  return before.find_first_not_of(" \t") == std::string_view::npos;
}

std::string_view TokenCursor::Text(const Token& token) const {
  return source_.text().substr(token.begin, token.end - token.begin);
}

std::string TokenCursor::Quote(const Token& token) const { return Quote(SpanOf(token)); }

std::string TokenCursor::Quote(const text::Span& span) const {
  return text::Concat(
      {"'", Shorten(source_.text().substr(span.begin, span.end - span.begin)), "'"});
}

std::string TokenCursor::Describe(const Token& token) const {
  switch (token.kind) {
    case TokenKind::kEnd:
      return "the end of the file";
    case TokenKind::kNewline:
      return "the end of the line";
    case TokenKind::kText:
      return text::Concat({"the text ", Shorten(Text(token))});
    case TokenKind::kNumber:
      return text::Concat({"the number ", Shorten(Text(token))});
    default:
      return Quote(token);
  }
}

void TokenCursor::ReportUnexpected(std::string_view expected, std::string help) {
  const Token& token = Peek();
  if (token.faulty) return;
  const bool line_end = token.kind == TokenKind::kNewline;
  // The end of a line has no width, and CR LF would underline two empty columns.
  const text::Span span = line_end ? text::Span{&source_, token.begin, token.begin} : SpanOf(token);
  Report(kUnexpectedToken, span, text::Concat({"expected ", expected, ", not ", Describe(token)}),
         std::move(help));
}

bool TokenCursor::FitsDepth(int height, const text::Span& span) {
  if (depth_ + height <= kMaxDepth) return true;
  if (std::exchange(gave_up_, true)) return false;
  Report(kTooDeep, span,
         text::Concat({"this is nested more deeply than ", std::to_string(kMaxDepth), " levels"}),
         "blocks, parentheses, calls and operators count; name parts of it with 'let'");
  return false;
}

// `my-name` is one word to the user.
Name TokenCursor::TakeHyphened(bool digits_too) {
  const Token path = Take();
  Name name{std::string(Text(path)), SpanOf(path)};
  const auto goes_on = [&] {
    const TokenKind next = Peek(1).kind;
    return At(TokenKind::kMinus) && Peek().begin == name.span.end && Peek(1).begin == Peek().end &&
           (next == TokenKind::kPath || (digits_too && next == TokenKind::kNumber));
  };
  if (!goes_on()) return name;
  while (goes_on()) {
    Take();
    const Token part = Take();
    name.text += '_' + std::string(Text(part));
    name.span.end = part.end;
  }
  Report(kBadName, name.span, "a name cannot contain '-'", text::Concat({"write ", name.text}));
  return name;
}

Name TokenCursor::TakePath() {
  Name name = TakeHyphened(false);
  RefuseReserved(name);
  return name;
}

void TokenCursor::RefuseReserved(const Name& path) {
  for (std::size_t begin = 0; begin <= path.text.size();) {
    const std::size_t end = std::min(path.text.find('.', begin), path.text.size());
    const std::string part = path.text.substr(begin, end - begin);
    if (IsReserved(part)) {
      const auto at = path.span.begin + static_cast<std::uint32_t>(begin);
      Report(kReservedWord, {&source_, at, at + static_cast<std::uint32_t>(part.size())},
             text::Concat({"'", part, "' is a reserved word, so nothing else can have this name"}));
    }
    begin = end + 1;
  }
}

std::optional<Name> TokenCursor::ParseName(std::string_view what, bool within_value) {
  if (At(TokenKind::kPath)) {
    const Token token = Peek();
    Name name = within_value ? Name{std::string(Text(token)), SpanOf(Take())} : TakeHyphened(true);
    RefuseReserved(name);
    const bool reported = token.faulty || name.span.end != token.end;
    if (!reported && name.text.find('.') != std::string::npos)
      Report(kBadName, name.span, text::Concat({"the name of ", what, " has no '.' in it"}));
    return name;
  }
  if (At(TokenKind::kNumber)) {
    if (!Peek().faulty)
      Report(kBadName, SpanOf(Peek()),
             text::Concat({"the name of ", what, " does not begin with a digit"}));
    const Token token = Take();
    return Name{std::string(Text(token)), SpanOf(token)};
  }
  return std::nullopt;
}

}  // namespace cdb::dsl
