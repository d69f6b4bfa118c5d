#include "dsl/statement_parser.h"

#include <algorithm>
#include <utility>

#include "dsl/diagnostics.h"
#include "dsl/text/concat.h"
#include "dsl/text/units.h"

namespace cdb::dsl {

void StatementParser::ParseStatement(std::vector<Statement>& statements) {
  const Token first = cursor_.Peek();
  const int faults = cursor_.fault_count();
  cursor_.BeginStatement();
  std::optional<Statement> statement;
  const auto keep = [&](auto parsed) {
    if (parsed)
      statement = Statement{cursor_.SpanFrom(first.begin), std::move(*parsed)};
    else
      AddDamage(Damage::kLost);
  };
  if (cursor_.AtWord("let")) {
    keep(ParseLet());
  } else if (cursor_.AtWord("cases")) {
    keep(ParseCases());
  } else if (cursor_.AtWord("skip") || cursor_.AtWord("only")) {
    keep(std::optional(ParseSkip()));
  } else if (cursor_.AtWord("require")) {
    keep(std::optional(ParseRequire()));
  } else if (cursor_.AtWord("benchmark") || cursor_.AtWord("use")) {
    ParseMisplaced();
  } else if (RefuseLoop()) {
  } else if (first.kind == TokenKind::kPath) {
    Name path = cursor_.TakePath();
    RefuseSign();
    if (AtGroup()) {
      if (auto group = ParseGroup(path, first.faulty))
        keep(std::move(group));
      else
        keep(std::optional(Setting{std::move(path), {}}));
    } else {
      keep(std::optional(ParseSetting(std::move(path))));
    }
  } else if (first.kind == TokenKind::kLeftBrace) {
    cursor_.Report(kUnexpectedToken, cursor_.SpanOf(first), "a block needs a name before its '{'");
    AddDamage(Damage::kLost);
    Block dropped;
    ParseBlock(dropped, cursor_.SpanOf(first));
  } else {
    SkipNoStatement(first);
  }
  EndStatement();
  std::vector<Let> more = std::exchange(more_lets_, {});
  if (!statement) return;
  const text::Span span = statement->span;
  Poison(*statement, faults);
  statements.push_back(std::move(*statement));
  for (Let& let : more) {
    Statement next{span, std::move(let)};
    Poison(next, faults);
    statements.push_back(std::move(next));
  }
}

/// True if the token is a name right after a value, and no unit.
bool StatementParser::BeginsAnotherValue(std::size_t ahead) const {
  const TokenKind before = cursor_.Peek(ahead - 1).kind;
  return cursor_.Peek(ahead).kind == TokenKind::kPath &&
         (before == TokenKind::kNumber || before == TokenKind::kPath ||
          before == TokenKind::kText || before == TokenKind::kRightParen) &&
         !text::IsUnitName(cursor_.Text(cursor_.Peek(ahead)));
}

void StatementParser::RefuseSign() {
  const Token sign = cursor_.Peek();
  if (sign.kind != TokenKind::kAssign && sign.kind != TokenKind::kColon) return;
  if (!sign.faulty) {
    const std::string name(cursor_.Text(cursor_.Previous()));
    std::size_t last = 0;
    while (!cursor_.AtStatementEnd(last + 1) && !BeginsAnotherValue(last + 1)) ++last;
    const bool is_block = cursor_.Peek(1).kind == TokenKind::kLeftBrace;
    const std::string text =
        is_block ? "{ … }"
        : last == 0
            ? "…"
            : cursor_.Excerpt({&cursor_.source(), cursor_.Peek(1).begin, cursor_.Peek(last).end});
    const bool may_be_let =
        sign.kind == TokenKind::kAssign && !is_block && name.find('.') == std::string::npos;
    cursor_.Report(kEqualsInSetting, cursor_.SpanOf(sign),
                   text::Concat({"a setting is written without ", cursor_.Quote(sign)}),
                   text::Concat({"write ", name, " ", text,
                                 may_be_let ? text::Concat({"; or let ", name, " = ", text,
                                                            " for a name of yours"})
                                            : std::string()}));
  }
  cursor_.Take();
}

void StatementParser::SkipNoStatement(const Token& first) {
  if (first.kind == TokenKind::kRightParen || first.kind == TokenKind::kRightBracket)
    ReportStrayBracket();
  else if (!first.faulty)
    cursor_.Report(
        kUnexpectedToken, cursor_.SpanOf(first),
        text::Concat({"a statement must begin with a name, not with ", cursor_.Describe(first)}));
  AddDamage(Damage::kLost);
  cursor_.Take();
  SkipStatement();
}

void StatementParser::Poison(Let& let) {
  let.value = std::make_unique<Expr>();
  let.value->kind = ExprKind::kError;
  let.value->span = let.name.span;
}

void StatementParser::Poison(Statement& statement, int faults) {
  const bool is_sound = cursor_.fault_count() == faults;
  if (auto* let = std::get_if<Let>(&statement.what)) {
    if (!is_sound || !let->value) Poison(*let);
  } else if (auto* skip = std::get_if<Skip>(&statement.what)) {
    if (!is_sound) skip->when = nullptr;
  } else if (auto* require = std::get_if<Require>(&statement.what)) {
    if (!is_sound) require->what = nullptr;
  } else if (auto* setting = std::get_if<Setting>(&statement.what)) {
    if (is_sound && !setting->values.empty()) return;
    setting->values.clear();
    setting->values.push_back(std::make_unique<Expr>());
    setting->values[0]->kind = ExprKind::kError;
    setting->values[0]->span = setting->path.span;
  }
}

void StatementParser::ParseMisplaced() {
  AddDamage(Damage::kMisnested);
  const Token word = cursor_.Peek();
  cursor_.Report(kMisplacedStatement, cursor_.SpanOf(word),
                 cursor_.Quote(word) + " is not allowed inside a block",
                 "it must be outside all blocks, at the start of a line");
  if (cursor_.AtWord("use"))
    ParseUse();
  else
    ParseBenchmark();
}

bool StatementParser::AtGroup() const {
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

std::optional<Group> StatementParser::ParseGroup(Name kind, bool faulty) {
  Group group;
  if (cursor_.At(TokenKind::kText)) {
    const Token text = cursor_.Take();
    if (!text.faulty)
      cursor_.Report(kBadName, cursor_.SpanOf(text),
                     "the name of a group is written without quotes");
  } else if (cursor_.At(TokenKind::kPath)) {
    group.label = cursor_.ParseName("a group");
  }
  if (cursor_.At(TokenKind::kLeftBrace) && ListInBraces()) {
    const Token brace = cursor_.Peek();
    SkipBraces();
    cursor_.Report(kBracesForList, cursor_.SpanFrom(brace.begin), "values are not written in { }",
                   "a vector is written (x, y, z), a list a, b, c");
    return std::nullopt;
  }
  if (!faulty && kind.text.find('.') != std::string::npos)
    cursor_.Report(kBadName, kind.span, "the name of a block cannot contain '.'",
                   "nest one block in the other");
  const text::Span owner = kind.span;
  group.kind = std::move(kind);
  if (!ParseBlock(group.block, owner)) return std::nullopt;
  return group;
}

Setting StatementParser::ParseSetting(Name path) {
  Setting setting;
  setting.path = std::move(path);
  if (cursor_.AtStatementEnd()) {
    const bool sign = cursor_.Previous().kind == TokenKind::kAssign ||
                      cursor_.Previous().kind == TokenKind::kColon;
    if (!sign)
      cursor_.Report(kMissingValue, setting.path.span,
                     text::Concat({"'", setting.path.text, "' has no value"}));
  } else if (!ParseMoreValues(setting)) {
    SkipStatement();
  }
  return setting;
}

bool StatementParser::ParseMoreValues(Setting& setting) {
  std::optional<Token> comma;  // before the current value, if there is one
  bool comma_reported = false;
  while (true) {
    const std::size_t start = cursor_.index();
    const Token first = cursor_.Peek();
    ExprPtr value = values_.ParseValue();
    if (!value) return false;
    if (comma && IsTrailing(*comma, first, *value)) {
      cursor_.Report(kTrailingComma, cursor_.SpanOf(*comma),
                     "after this ',' the list continues on the next line",
                     "remove it if the list ends here");
      cursor_.Rewind(start);
      statement_begins_ = true;
      return true;
    }
    if (RefuseSecondArgument(*value)) return false;
    if (comma && RefuseCommaBetweenStatements(setting, *comma, start, *value)) return true;
    const ExprKind kind = value->kind;
    const std::string word = value->text;
    setting.values.push_back(std::move(value));
    if (cursor_.At(TokenKind::kComma)) {
      comma = cursor_.Take();
      if (!cursor_.AtStatementEnd()) continue;
      cursor_.Report(kTrailingComma, cursor_.SpanOf(*comma), "no value follows this ','",
                     "remove it");
      return true;
    }
    comma.reset();
    const Token next = cursor_.Peek();
    if (!cursor_.AtValueStart() || next.faulty || cursor_.AtWord("as")) return true;
    if (RefuseWordOfRange(setting) || RefuseUnit(setting) || RefuseSecondNumber(setting))
      return false;
    if (RefuseMissingSemicolon(kind, word)) return true;
    if (!comma_reported)
      cursor_.Report(kMissingComma, cursor_.SpanOf(next),
                     text::Concat({"a ',' is missing before ", cursor_.Quote(next)}),
                     kind == ExprKind::kPath && next.kind != TokenKind::kPath
                         ? text::Concat({"arguments are written in parentheses: ", word, "(…)"})
                         : "");
    comma_reported = true;
  }
}

/// True if the comma is the error: `record timing,` and on the next line `cycles 5`. `value` begins
/// with `first`.
bool StatementParser::IsTrailing(const Token& comma, const Token& first, const Expr& value) const {
  const auto line_of = [&](const Token& token) {
    return cursor_.source().PositionAt(token.begin).line;
  };
  const bool next_statement = value.kind == ExprKind::kPath && first.kind == TokenKind::kPath &&
                              (cursor_.AtValueStart() || cursor_.At(TokenKind::kLeftBrace) ||
                               cursor_.At(TokenKind::kAssign));
  return next_statement && line_of(comma) < line_of(first);
}

/// At `ring radius: 20 gap: 2` or `ring radius: 20, gap: 2`: true, with a report.
bool StatementParser::RefuseSecondArgument(const Expr& value) {
  const bool after_comma = cursor_.At(TokenKind::kComma);
  if (!value.bare || !(values_.AtLabel() || (after_comma && values_.AtLabel(1)))) return false;
  const Token& label = cursor_.Peek(after_comma ? 1 : 0);
  cursor_.Report(
      kMissingBrackets, cursor_.SpanOf(label),
      text::Concat({"several arguments of '", value.text, "' are written in parentheses"}),
      text::Concat({"write: ", value.text, "(", value.arguments[0].name->text, ": …, ",
                    cursor_.Text(label), ": …)"}));
  return true;
}

/// At `quantity 5, type sphere`: true, with a report. The parser goes on with the second statement,
/// whose name is `value`, from token `start` on.
bool StatementParser::RefuseCommaBetweenStatements(const Setting& setting, const Token& comma,
                                                   std::size_t start, const Expr& value) {
  const bool is_list_of_words = setting.values.front()->kind == ExprKind::kPath;
  if (is_list_of_words || value.kind != ExprKind::kPath || !cursor_.AtValueStart()) return false;
  cursor_.Report(kMissingSemicolon, cursor_.SpanOf(comma), "a ',' does not end a statement",
                 text::Concat({"write ';', or begin a new line with ", cursor_.Quote(value.span)}));
  cursor_.Rewind(start);
  statement_begins_ = true;
  return true;
}

/// At `timestep 10 seconds` or `timestep n ms`: true, with a report.
bool StatementParser::RefuseUnit(const Setting& setting) {
  const Token next = cursor_.Peek();
  if (next.kind != TokenKind::kPath) return false;
  const std::string_view word = cursor_.Text(next);
  const Expr& value = *setting.values.back();
  const ExprKind last = value.kind;
  const bool is_number = last == ExprKind::kNumber || last == ExprKind::kBinary ||
                         last == ExprKind::kNegate || last == ExprKind::kVector;
  const std::string_view unit = text::UnitCalled(word);
  const bool ends = cursor_.AtStatementEnd(1);
  if (ends && text::IsUnitName(word) && cursor_.Previous().kind == TokenKind::kPath) {
    const std::string written = cursor_.Excerpt(value.span);
    cursor_.Report(kWrittenUnit, cursor_.SpanOf(next),
                   "a unit must follow a number or a parenthesis",
                   text::Concat({"write (", written, ") ", word}));
    return true;
  }
  if (is_number && (!unit.empty() || ends)) {
    cursor_.Report(kWrittenUnit, cursor_.SpanOf(next), cursor_.Quote(next) + " is not a unit",
                   unit.empty() ? text::Concat({"units are ", text::UnitNames()})
                                : text::Concat({"write ", unit}));
    return true;
  }
  return false;
}

/// At `quantity 100 to 1000`: true, with a report.
bool StatementParser::RefuseWordOfRange(const Setting& setting) {
  const ExprKind last = setting.values.back()->kind;
  const bool is_number = last == ExprKind::kNumber || last == ExprKind::kNegate;
  if (!is_number || !(cursor_.AtWord("to") || cursor_.AtWord("through") || cursor_.AtWord("until")))
    return false;
  const Token& end = cursor_.Peek(1);
  if (end.kind != TokenKind::kNumber) return false;
  const text::Span& begin = setting.values.back()->span;
  cursor_.Report(kBadRange, cursor_.SpanOf(cursor_.Peek()), "a range is written with '..'",
                 text::Concat({"write sweep(",
                               cursor_.source().text().substr(begin.begin, begin.end - begin.begin),
                               " .. ", cursor_.Text(end), ") for one run with each value"}));
  return true;
}

/// At `cycles 5 6`: true, with a report.
bool StatementParser::RefuseSecondNumber(const Setting& setting) {
  const Expr& last = *setting.values.back();
  const bool is_number = last.kind == ExprKind::kNumber || last.kind == ExprKind::kNegate;
  if (!is_number || !cursor_.At(TokenKind::kNumber)) return false;
  const Token next = cursor_.Peek();
  const std::string_view first =
      cursor_.source().text().substr(last.span.begin, last.span.end - last.span.begin);
  cursor_.Report(
      kTwoValues, cursor_.SpanOf(next),
      text::Concat({"'", setting.path.text, "' has a second value"}),
      text::Concat({"for one run with each, write sweep(", first, ", ", cursor_.Text(next), ")"}));
  return true;
}

/// At `for i in 1..3 { }`: true, with a report.
bool StatementParser::RefuseLoop() {
  const Token word = cursor_.Peek();
  const bool is_branch = cursor_.AtWord("if");
  if (!is_branch && !cursor_.AtWord("for") && !cursor_.AtWord("while") &&
      !cursor_.AtWord("foreach") && !cursor_.AtWord("repeat"))
    return false;
  if (!cursor_.AtValueStart(1)) return false;
  const bool is_count = cursor_.AtWord("repeat") && cursor_.Peek(1).kind == TokenKind::kNumber &&
                        cursor_.Peek(2).kind != TokenKind::kLeftBrace;
  cursor_.Report(kNoLoops, cursor_.SpanOf(word),
                 text::Concat({"there is no ", cursor_.Quote(word), " in this language"}),
                 is_branch  ? "skip when … skips runs; cases { } sets several values together"
                 : is_count ? text::Concat({"write repeats ", cursor_.Text(cursor_.Peek(1)),
                                            " to measure each run as often"})
                            : std::string("sweep(1 .. 3) makes a run for each value"));
  AddDamage(Damage::kLost);
  SkipStatement();
  return true;
}

/// True, with a report, if another statement seems to begin after the last value, whose text is
/// `word`.
bool StatementParser::RefuseMissingSemicolon(ExprKind last, const std::string& word) {
  const Token next = cursor_.Peek();
  const bool is_statement =
      next.kind == TokenKind::kPath &&
      (cursor_.AtValueStart(1) || cursor_.Peek(1).kind == TokenKind::kLeftBrace ||
       cursor_.Peek(1).kind == TokenKind::kAssign || cursor_.Peek(1).kind == TokenKind::kColon ||
       IsReserved(cursor_.Text(next)));
  if (!is_statement) return false;
  cursor_.Report(
      kMissingSemicolon, cursor_.SpanOf(next),
      text::Concat({"a ';' or a ',' is missing before ", cursor_.Quote(next)}),
      last == ExprKind::kPath
          ? text::Concat({"';' before another statement, ',' before another value; or write: ",
                          word, "(", cursor_.Text(next), ": …)"})
          : "';' before another statement, ',' before another value");
  statement_begins_ = true;
  return true;
}

std::optional<Cases> StatementParser::ParseCases() {
  Cases cases;
  cases.keyword = cursor_.SpanOf(cursor_.Take());
  if (cursor_.At(TokenKind::kPath)) cases.name = cursor_.ParseName("an axis");
  const text::Span owner = cursor_.SpanFrom(cases.keyword.begin);
  text::Span braces;
  const bool parsed = ParseBraces(braces, owner, [&] {
    if (std::optional<Case> one = ParseCase()) cases.cases.push_back(std::move(*one));
  });
  if (!parsed) return std::nullopt;
  return cases;
}

std::optional<Case> StatementParser::ParseCase() {
  const Token first = cursor_.Peek();
  if (first.kind == TokenKind::kComma) {
    cursor_.Take();
    cursor_.Report(kUnexpectedToken, cursor_.SpanOf(first), "cases are not separated by ','",
                   "remove it");
    return std::nullopt;
  }
  std::optional<Case> result;
  const int faults = cursor_.fault_count();
  if (std::optional<Name> name = cursor_.ParseName("a case")) {
    Case one;
    one.name = std::move(*name);
    if (cursor_.At(TokenKind::kAssign) || cursor_.At(TokenKind::kColon)) {
      const Token sign = cursor_.Take();
      cursor_.Report(kEqualsInSetting, cursor_.SpanOf(sign),
                     text::Concat({"a case is written without ", cursor_.Quote(sign)}),
                     "write NAME { … }");
    }
    if (cursor_.At(TokenKind::kText)) one.title = TextContents(cursor_.Text(cursor_.Take()));
    const bool setting = cursor_.AtValueStart() && !cursor_.Peek().faulty;
    if (setting) {
      cursor_.Report(kMissingBlock, one.name.span, "a case has a block, not a value",
                     text::Concat({"write ", one.name.text, " { … }"}));
      SkipStatement();
    } else if (cursor_.fault_count() > faults && cursor_.AtStatementEnd()) {
      // An error in its name was reported; a missing block would be a second error for one mistake.
    } else if (ParseBlock(one.block, one.name.span)) {
      result = std::move(one);
    }
  } else {
    if (!first.faulty)
      cursor_.Report(
          kUnexpectedToken, cursor_.SpanOf(first),
          text::Concat({"a case must begin with its name, not with ", cursor_.Describe(first)}),
          "write NAME { … }");
    if (first.kind == TokenKind::kLeftBrace) {
      Block dropped;
      ParseBlock(dropped, cursor_.SpanOf(first));
    } else {
      cursor_.Take();
      SkipStatement();
    }
  }
  if (!result) AddDamage(Damage::kLost);
  if (!cursor_.At(TokenKind::kComma)) EndStatement();
  return result;
}

Skip StatementParser::ParseSkip() {
  Skip skip;
  skip.is_only = cursor_.AtWord("only");
  const Token word = cursor_.Take();
  const std::string name = skip.is_only ? "only" : "skip";
  if (cursor_.AtWord("when")) {
    cursor_.Take();
  } else if (cursor_.AtStatementEnd()) {
    cursor_.Report(kMissingWhen, cursor_.SpanOf(word),
                   text::Concat({"'", name, "' does not state which points to ",
                                 skip.is_only ? "run" : "skip"}),
                   text::Concat({"for example: ", name, " when quantity > 3000"}));
    return skip;
  } else {
    const Token next = cursor_.Peek();
    const bool instead =
        cursor_.AtWord("if") || cursor_.AtWord("where") || cursor_.AtWord("unless");
    if (!next.faulty)
      cursor_.Report(kMissingWhen, cursor_.SpanOf(instead ? next : word),
                     text::Concat({"'", name, "' is followed by 'when'"}),
                     text::Concat({"write: ", name, " when …"}));
    if (instead) cursor_.Take();
  }
  skip.when = values_.ParseCondition();
  if (!skip.when) SkipStatement();
  return skip;
}

Require StatementParser::ParseRequire() {
  Require require;
  const Token word = cursor_.Take();
  if (cursor_.AtStatementEnd()) {
    cursor_.Report(kMissingComparison, cursor_.SpanOf(word),
                   "'require' does not state what is required",
                   "for example: require p99(step) < 4 ms");
    return require;
  }
  require.what = values_.ParseCondition();
  if (!require.what) SkipStatement();
  return require;
}

}  // namespace cdb::dsl
