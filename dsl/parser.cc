#include "dsl/parser.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dsl/concat.h"
#include "dsl/diagnostic_kinds.h"
#include "dsl/token_cursor.h"
#include "dsl/value_parser.h"

namespace cdb::dsl {
namespace {

class Parser {
 public:
  Parser(const Source& source, Diagnostics& diagnostics)
      : cursor_(source, diagnostics), values_(cursor_) {}

  void ParseItems(File& file);

 private:
  Use ParseUse();
  std::optional<Let> ParseLet();
  std::optional<Benchmark> ParseBenchmark();
  void ParseStatement(std::vector<Statement>& statements);
  std::optional<Cases> ParseCases();
  std::optional<Case> ParseCase();
  std::optional<Skip> ParseSkip();
  bool AtGroup() const;
  std::optional<Group> ParseGroup(Name kind, bool faulty);
  std::optional<Setting> ParseSetting(Name path);
  bool ParseMoreValues(Setting& setting);
  void ParseMisplaced();

  /// A block and its braces. False where there is none, which is reported as missing from `owner`.
  bool ParseBlock(Block& block, const Span& owner);
  /// Calls `parse_one` for everything between the braces.
  template <typename ParseOne>
  bool ParseBraces(Span& span, const Span& owner, ParseOne parse_one);
  bool ListInBraces() const;
  void SkipBraces();
  void ReportUnclosed();
  bool AtFileItem() const;

  /// After a statement: its end has to be here.
  void EndStatement();
  void ReportStrayBracket();
  /// To the end of the statement; blocks on the way are still checked.
  void SkipStatement();
  void SkipEmpty() {
    while (cursor_.At(TokenKind::kNewline) || cursor_.At(TokenKind::kSemicolon)) cursor_.Take();
  }

  struct OpenBlock {
    Span brace;
    std::uint32_t indent;  // of the line on which it opens
  };
  std::uint32_t IndentAt(std::uint32_t offset) const;

  TokenCursor cursor_;
  ValueParser values_;
  std::vector<OpenBlock> open_;
  // The brace of a block that was closed by a '}' further left than it should be: where a '}' is
  // missing at the end, it is this block's, whatever the count says.
  std::optional<Span> suspect_;
  bool unclosed_reported_ = false;
  bool statement_begins_ = false;  // where a statement's end is missing and was reported
};

// ------------------------------------------------------------------------------------ the file

void Parser::ParseItems(File& file) {
  bool misplaced_reported = false;
  while (true) {
    SkipEmpty();
    open_.clear();
    suspect_.reset();
    unclosed_reported_ = false;
    cursor_.BeginStatement();
    const Token token = cursor_.Peek();
    if (token.kind == TokenKind::kEnd) return;
    if (cursor_.AtWord("use")) {
      file.items.emplace_back(ParseUse());
    } else if (cursor_.AtWord("let")) {
      if (std::optional<Let> let = ParseLet()) file.items.emplace_back(std::move(*let));
    } else if (cursor_.AtWord("benchmark")) {
      misplaced_reported = false;
      if (auto benchmark = ParseBenchmark()) file.items.emplace_back(std::move(*benchmark));
    } else if (token.kind == TokenKind::kRightBrace) {
      cursor_.Report(kStrayBrace, cursor_.SpanOf(token), "no block is open that this '}' closes");
      cursor_.Take();
      continue;
    } else if (token.kind == TokenKind::kPath) {
      // One report for a whole row of them: it is one slip.
      const std::string_view meant = DidYouMean(cursor_.Text(token), {"benchmark", "use", "let"});
      if ((!misplaced_reported || !meant.empty()) && !token.faulty)
        cursor_.Report(kMisplacedStatement, cursor_.SpanOf(token),
                       cursor_.Quote(token) + " cannot stand outside a benchmark",
                       meant.empty() ? "a file holds use, let and benchmark NAME { … }"
                                     : Concat({"did you mean '", meant, "'?"}));
      misplaced_reported |= meant.empty();
      if (meant == "benchmark") {
        ParseBenchmark();
      } else if (meant.empty()) {
        std::vector<Statement> dropped;
        ParseStatement(dropped);
        continue;
      } else {
        SkipStatement();
      }
    } else {
      cursor_.ReportUnexpected("use, let or benchmark");
      SkipStatement();
    }
    EndStatement();
  }
}

Use Parser::ParseUse() {
  const Token word = cursor_.Take();
  Use use;
  if (cursor_.AtWord("detector")) {
    cursor_.Take();
    use.detector = true;
  }
  if (cursor_.At(TokenKind::kText)) {
    const Token text = cursor_.Take();
    use.path = TextContents(cursor_.Text(text));
    use.path_span = cursor_.SpanOf(text);
  } else if (cursor_.AtStatementEnd()) {
    cursor_.Report(
        kMissingValue, cursor_.SpanOf(cursor_.Previous()),
        cursor_.Quote(cursor_.Previous()) + " needs a file's name after it",
        use.detector ? "for example: use detector \"mine.so\"" : "for example: use \"base.cdb\"");
  } else {
    // A bare file name falls into many tokens; to the person it is one.
    const std::uint32_t begin = cursor_.Peek().begin;
    const bool faulty = cursor_.Peek().faulty;
    while (!cursor_.AtStatementEnd() && !cursor_.At(TokenKind::kLeftBrace)) cursor_.Take();
    if (!faulty && cursor_.Previous().end > begin) {
      const Span span = cursor_.SpanFrom(begin);
      cursor_.Report(
          kMissingQuotes, span, "a file's name stands in quotes",
          Concat({"write \"", cursor_.source().text().substr(span.begin, span.end - span.begin),
                  "\""}));
    }
  }
  use.span = cursor_.SpanFrom(word.begin);
  return use;
}

std::optional<Let> Parser::ParseLet() {
  const Token word = cursor_.Take();
  std::optional<Name> name = cursor_.ParseName("a let");
  if (!name) {
    if (!cursor_.Peek().faulty)
      cursor_.Report(kMissingName, cursor_.SpanOf(word), "'let' needs a name after it",
                     "for example: let n = sweep(10, 100)");
    SkipStatement();
    return std::nullopt;
  }
  if (cursor_.At(TokenKind::kAssign)) {
    cursor_.Take();
  } else if (cursor_.AtStatementEnd()) {
    cursor_.Report(kMissingEquals, name->span, "this name is given no value",
                   Concat({"write: let ", name->text, " = …"}));
    return std::nullopt;
  } else {
    const Token& found = cursor_.Peek();
    const bool instead = found.kind == TokenKind::kColon || found.kind == TokenKind::kEqual;
    if (!found.faulty)
      cursor_.Report(kMissingEquals, cursor_.SpanOf(found),
                     Concat({"expected '=' before the value, not ", cursor_.Describe(found)}),
                     Concat({"write: let ", name->text, " = …"}));
    if (instead) cursor_.Take();
  }
  ExprPtr value = values_.ParseValue();
  if (!value) {
    SkipStatement();
    return std::nullopt;
  }
  if (cursor_.At(TokenKind::kComma)) {
    cursor_.Report(kOneValue, cursor_.SpanOf(cursor_.Peek()), "a let holds one value",
                   "to vary it, write sweep(a, b)");
    SkipStatement();
  }
  return Let{std::move(*name), std::move(value)};
}

std::optional<Benchmark> Parser::ParseBenchmark() {
  const Token word = cursor_.Take();
  Benchmark benchmark;
  std::optional<Name> name;
  if (!cursor_.AtWord("from") || cursor_.Peek(1).kind != TokenKind::kPath)
    name = cursor_.ParseName("a benchmark");
  if (name) {
    benchmark.name = std::move(*name);
  } else if (!cursor_.Peek().faulty || cursor_.At(TokenKind::kText)) {
    cursor_.Report(kMissingName, cursor_.SpanOf(word), "'benchmark' needs a name after it",
                   "for example: benchmark aspect \"what it asks\" { … }");
  }
  bool titled = false;
  while (cursor_.AtWord("from") || (cursor_.At(TokenKind::kText) && !titled)) {
    const Token token = cursor_.Take();
    if (token.kind == TokenKind::kText) {
      benchmark.title = TextContents(cursor_.Text(token));
      titled = true;
      continue;
    }
    if (titled || benchmark.from)
      cursor_.Report(kMisplacedFrom, cursor_.SpanOf(token),
                     titled ? "'from' stands before the title" : "there is one 'from' at most",
                     "write: benchmark NAME from OTHER \"title\" { … }");
    benchmark.from = cursor_.ParseName("a benchmark");
    if (!benchmark.from && !cursor_.Peek().faulty)
      cursor_.Report(kMissingName, cursor_.SpanOf(token),
                     "'from' needs the name of a benchmark after it");
  }
  const Span owner = cursor_.SpanFrom(word.begin);
  if (!ParseBlock(benchmark.block, owner)) return std::nullopt;
  benchmark.span = cursor_.SpanFrom(word.begin);
  return benchmark;
}

// -------------------------------------------------------------------------------------- blocks

std::uint32_t Parser::IndentAt(std::uint32_t offset) const {
  const Source& source = cursor_.source();
  const std::uint32_t begin = source.LineStart(source.PositionAt(offset).line);
  const std::size_t first = source.text().find_first_not_of(" \t", begin);
  return static_cast<std::uint32_t>(first) - begin;
}

bool Parser::AtFileItem() const {
  const Token& token = cursor_.Peek();
  return (cursor_.AtWord("benchmark") || cursor_.AtWord("use")) && IndentAt(token.begin) == 0 &&
         cursor_.FirstOnLine(token);
}

void Parser::ReportUnclosed() {
  if (unclosed_reported_) return;
  unclosed_reported_ = true;
  const Token& found = cursor_.Peek();
  std::vector<Note> notes;
  Span brace = open_.back().brace;
  if (suspect_) {
    brace = *suspect_;
  } else {
    for (std::size_t i = open_.size() - 1; i-- > 0;)
      notes.push_back({open_[i].brace, "this '{' is open too"});
  }
  notes.push_back({cursor_.SpanOf(found),
                   found.kind == TokenKind::kEnd
                       ? "the file ends here"
                       : cursor_.Quote(found) + " begins here, which stands outside blocks"});
  cursor_.Report(kUnclosedBlock, brace, "this '{' has no '}'", "", std::move(notes));
}

template <typename ParseOne>
bool Parser::ParseBraces(Span& span, const Span& owner, ParseOne parse_one) {
  if (cursor_.At(TokenKind::kNewline) && cursor_.Peek(1).kind == TokenKind::kLeftBrace) {
    cursor_.Take();
    cursor_.Report(kBraceOnOwnLine, cursor_.SpanOf(cursor_.Peek()),
                   "a block begins on the line of its name",
                   "put the '{' at the end of the line above");
  }
  // Lines that stand further in are the block, though its '{' is missing.
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

bool Parser::ParseBlock(Block& block, const Span& owner) {
  return ParseBraces(block.span, owner, [&] { ParseStatement(block.statements); });
}

// From a '{' to behind its '}', without a look inside.
void Parser::SkipBraces() {
  int depth = 0;
  while (!cursor_.At(TokenKind::kEnd)) {
    const TokenKind kind = cursor_.Take().kind;
    if (kind == TokenKind::kLeftBrace) ++depth;
    if (kind == TokenKind::kRightBrace && --depth == 0) return;
  }
}

// `{1, 2, 3}` and `{a, b}`: what other languages write for a vector or a list.
bool Parser::ListInBraces() const {
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

// ---------------------------------------------------------------------------------- statements

void Parser::ParseStatement(std::vector<Statement>& statements) {
  const Token first = cursor_.Peek();
  cursor_.BeginStatement();
  Statement statement;
  const auto keep = [&](auto parsed) {
    if (!parsed) return;
    statement.what = std::move(*parsed);
    statement.span = cursor_.SpanFrom(first.begin);
    statements.push_back(std::move(statement));
  };
  if (cursor_.AtWord("let")) {
    keep(ParseLet());
  } else if (cursor_.AtWord("cases")) {
    keep(ParseCases());
  } else if (cursor_.AtWord("skip")) {
    keep(ParseSkip());
  } else if (cursor_.AtWord("benchmark") || cursor_.AtWord("use")) {
    ParseMisplaced();
  } else if (first.kind == TokenKind::kPath) {
    Name path = cursor_.TakePath();
    const Token sign = cursor_.Peek();
    if (sign.kind == TokenKind::kAssign || sign.kind == TokenKind::kColon) {
      if (!sign.faulty)
        cursor_.Report(kEqualsInSetting, cursor_.SpanOf(sign),
                       Concat({"a setting is written without ", cursor_.Quote(sign)}),
                       "write a space between the name and its value");
      cursor_.Take();
    }
    if (AtGroup())
      keep(ParseGroup(std::move(path), first.faulty));
    else
      keep(ParseSetting(std::move(path)));
  } else if (first.kind == TokenKind::kLeftBrace) {
    cursor_.Report(kUnexpectedToken, cursor_.SpanOf(first), "a block needs a name before its '{'");
    Block dropped;
    ParseBlock(dropped, cursor_.SpanOf(first));
  } else {
    if (first.kind == TokenKind::kRightParen || first.kind == TokenKind::kRightBracket)
      ReportStrayBracket();
    else if (!first.faulty)
      cursor_.Report(
          kUnexpectedToken, cursor_.SpanOf(first),
          Concat({"a statement begins with a name, not with ", cursor_.Describe(first)}));
    cursor_.Take();
    SkipStatement();
  }
  EndStatement();
}

void Parser::ParseMisplaced() {
  const Token word = cursor_.Peek();
  cursor_.Report(kMisplacedStatement, cursor_.SpanOf(word),
                 cursor_.Quote(word) + " cannot stand inside a block",
                 "it stands outside all blocks, at the start of a line");
  if (cursor_.AtWord("use"))
    ParseUse();
  else
    ParseBenchmark();
}

bool Parser::AtGroup() const {
  const auto at = [&](std::size_t ahead, TokenKind kind) {
    return cursor_.Peek(ahead).kind == kind;
  };
  if (at(0, TokenKind::kLeftBrace)) return true;
  if (at(0, TokenKind::kNewline)) return at(1, TokenKind::kLeftBrace);
  const bool label = at(0, TokenKind::kPath) || at(0, TokenKind::kText);
  if (!label) return false;
  return at(1, TokenKind::kLeftBrace) ||
         (at(1, TokenKind::kNewline) && at(2, TokenKind::kLeftBrace));
}

std::optional<Group> Parser::ParseGroup(Name kind, bool faulty) {
  Group group;
  if (cursor_.At(TokenKind::kText)) {
    const Token text = cursor_.Take();
    if (!text.faulty)
      cursor_.Report(kBadName, cursor_.SpanOf(text), "the name of a group stands without quotes");
  } else if (cursor_.At(TokenKind::kPath)) {
    group.label = cursor_.ParseName("a group");
  }
  if (cursor_.At(TokenKind::kLeftBrace) && ListInBraces()) {
    const Token brace = cursor_.Peek();
    SkipBraces();
    cursor_.Report(kBracesForList, cursor_.SpanFrom(brace.begin), "values do not stand in { }",
                   "a vector is written (x, y, z), a list a, b, c");
    return std::nullopt;
  }
  if (!faulty && kind.text.find('.') != std::string::npos)
    cursor_.Report(kBadName, kind.span, "the name of a block has no '.' in it",
                   "put one block into the other");
  const Span owner = kind.span;
  group.kind = std::move(kind);
  if (!ParseBlock(group.block, owner)) return std::nullopt;
  return group;
}

std::optional<Setting> Parser::ParseSetting(Name path) {
  if (cursor_.AtStatementEnd()) {
    const bool sign = cursor_.Previous().kind == TokenKind::kAssign ||
                      cursor_.Previous().kind == TokenKind::kColon;
    if (!sign)
      cursor_.Report(kMissingValue, path.span, Concat({"'", path.text, "' is given no value"}));
    return std::nullopt;
  }
  Setting setting;
  setting.path = std::move(path);
  if (!ParseMoreValues(setting)) {
    SkipStatement();
    return std::nullopt;
  }
  return setting;
}

bool Parser::ParseMoreValues(Setting& setting) {
  const auto line_of = [&](std::uint32_t offset) {
    return cursor_.source().PositionAt(offset).line;
  };
  Token comma;  // before the current value, where there is one
  bool after_comma = false;
  bool comma_reported = false;
  while (true) {
    const std::size_t start = cursor_.index();
    const Token first = cursor_.Peek();
    ExprPtr value = values_.ParseValue();
    if (!value) return false;
    // `record timing,` and on the next line `cycles 5`: the comma is what is wrong.
    const bool next_statement = value->kind == ExprKind::kPath && first.kind == TokenKind::kPath &&
                                (cursor_.AtValueStart() || cursor_.At(TokenKind::kLeftBrace) ||
                                 cursor_.At(TokenKind::kAssign));
    if (after_comma && next_statement && line_of(comma.begin) < line_of(first.begin)) {
      cursor_.Report(kTrailingComma, cursor_.SpanOf(comma),
                     "after this ',' the next line goes on with the list",
                     "leave it out if the list ends here");
      cursor_.Rewind(start);
      statement_begins_ = true;
      return true;
    }
    const ExprKind kind = value->kind;
    const std::string word = value->text;
    if (value->bare &&
        (values_.AtLabel() || (cursor_.At(TokenKind::kComma) && values_.AtLabel(1)))) {
      const Token& label = cursor_.Peek(cursor_.At(TokenKind::kComma) ? 1 : 0);
      cursor_.Report(kMissingBrackets, cursor_.SpanOf(label),
                     Concat({"several arguments of '", word, "' stand in brackets"}),
                     Concat({"write: ", word, "(", value->arguments[0].name->text, ": …, ",
                             cursor_.Text(label), ": …)"}));
      return false;
    }
    setting.values.push_back(std::move(value));
    if (cursor_.At(TokenKind::kComma)) {
      comma = cursor_.Take();
      after_comma = true;
      if (cursor_.AtStatementEnd()) {
        cursor_.Report(kTrailingComma, cursor_.SpanOf(comma), "no value follows this ','",
                       "leave it out");
        return true;
      }
      continue;
    }
    after_comma = false;
    const Token next = cursor_.Peek();
    if (!cursor_.AtValueStart() || next.faulty || cursor_.AtWord("as")) return true;
    if (next.kind == TokenKind::kPath &&
        (cursor_.AtValueStart(1) || cursor_.Peek(1).kind == TokenKind::kLeftBrace ||
         cursor_.Peek(1).kind == TokenKind::kAssign || cursor_.Peek(1).kind == TokenKind::kColon ||
         IsReserved(cursor_.Text(next)))) {
      cursor_.Report(kMissingSemicolon, cursor_.SpanOf(next),
                     Concat({"a ';' or a ',' is missing before ", cursor_.Quote(next)}),
                     kind == ExprKind::kPath
                         ? Concat({"';' before another statement, ',' before another value; or "
                                   "write: ",
                                   word, "(", cursor_.Text(next), ": …)"})
                         : "';' before another statement, ',' before another value");
      statement_begins_ = true;
      return true;
    }
    if (!comma_reported)
      cursor_.Report(kMissingComma, cursor_.SpanOf(next),
                     Concat({"a ',' is missing before ", cursor_.Quote(next)}),
                     kind == ExprKind::kPath && next.kind != TokenKind::kPath
                         ? Concat({"arguments stand in brackets: ", word, "(…)"})
                         : "");
    comma_reported = true;
  }
}

std::optional<Cases> Parser::ParseCases() {
  Cases cases;
  cases.keyword = cursor_.SpanOf(cursor_.Take());
  if (cursor_.At(TokenKind::kPath)) cases.name = cursor_.ParseName("an axis");
  const Span owner = cursor_.SpanFrom(cases.keyword.begin);
  Span braces;
  const bool parsed = ParseBraces(braces, owner, [&] {
    if (std::optional<Case> one = ParseCase()) cases.cases.push_back(std::move(*one));
  });
  if (!parsed) return std::nullopt;
  return cases;
}

std::optional<Case> Parser::ParseCase() {
  const Token first = cursor_.Peek();
  if (first.kind == TokenKind::kComma) {
    cursor_.Take();
    cursor_.Report(kUnexpectedToken, cursor_.SpanOf(first), "no ',' stands between cases",
                   "leave it out");
    return std::nullopt;
  }
  std::optional<Case> result;
  if (std::optional<Name> name = cursor_.ParseName("a case")) {
    Case one;
    one.name = std::move(*name);
    if (cursor_.At(TokenKind::kAssign) || cursor_.At(TokenKind::kColon)) {
      const Token sign = cursor_.Take();
      cursor_.Report(kEqualsInSetting, cursor_.SpanOf(sign),
                     Concat({"a case is written without ", cursor_.Quote(sign)}),
                     "write NAME { … }");
    }
    if (cursor_.At(TokenKind::kText)) one.title = TextContents(cursor_.Text(cursor_.Take()));
    const bool setting = cursor_.AtValueStart() && !cursor_.Peek().faulty;
    if (setting) {
      cursor_.Report(kMissingBlock, one.name.span, "a case has a block, and no value of its own",
                     Concat({"write ", one.name.text, " { … }"}));
      SkipStatement();
    } else if (ParseBlock(one.block, one.name.span)) {
      result = std::move(one);
    }
  } else {
    if (!first.faulty)
      cursor_.Report(kUnexpectedToken, cursor_.SpanOf(first),
                     Concat({"a case begins with its name, not with ", cursor_.Describe(first)}),
                     "write NAME { … }");
    if (first.kind == TokenKind::kLeftBrace) {
      Block dropped;
      ParseBlock(dropped, cursor_.SpanOf(first));
    } else {
      cursor_.Take();
      SkipStatement();
    }
  }
  if (!cursor_.At(TokenKind::kComma)) EndStatement();
  return result;
}

std::optional<Skip> Parser::ParseSkip() {
  const Token word = cursor_.Take();
  if (cursor_.AtWord("when")) {
    cursor_.Take();
  } else if (cursor_.AtStatementEnd()) {
    cursor_.Report(kMissingWhen, cursor_.SpanOf(word),
                   "'skip' does not say which points to leave out",
                   "for example: skip when quantity > 3000");
    return std::nullopt;
  } else {
    const Token next = cursor_.Peek();
    const bool instead =
        cursor_.AtWord("if") || cursor_.AtWord("where") || cursor_.AtWord("unless");
    if (!next.faulty)
      cursor_.Report(kMissingWhen, cursor_.SpanOf(instead ? next : word),
                     "'skip' is followed by 'when'", "write: skip when …");
    if (instead) cursor_.Take();
  }
  Skip skip;
  skip.when = values_.ParseCondition();
  if (!skip.when) {
    SkipStatement();
    return std::nullopt;
  }
  return skip;
}

// ------------------------------------------------------------------------------------ recovery

void Parser::EndStatement() {
  if (std::exchange(statement_begins_, false)) return;
  if (cursor_.AtStatementEnd() || cursor_.Previous().kind == TokenKind::kRightBrace) return;
  // A block that was left open ends where the file's next item begins.
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

void Parser::ReportStrayBracket() {
  const Token& token = cursor_.Peek();
  cursor_.Report(kStrayBracket, cursor_.SpanOf(token),
                 Concat({"no bracket is open that this ", cursor_.Quote(token), " closes"}));
}

void Parser::SkipStatement() {
  while (!cursor_.AtStatementEnd()) {
    if (cursor_.At(TokenKind::kLeftBrace)) {
      Block dropped;
      ParseBlock(dropped, cursor_.SpanOf(cursor_.Peek()));
      return;
    }
    cursor_.Take();
  }
}

}  // namespace

File Parse(std::shared_ptr<const Source> source, Diagnostics& diagnostics) {
  File file;
  file.source = std::move(source);
  Parser(*file.source, diagnostics).ParseItems(file);
  return file;
}

}  // namespace cdb::dsl
