#include "dsl/value_parser.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/text/concat.h"
#include "dsl/text/units.h"

namespace cdb::dsl {
namespace {

bool IsOperator(TokenKind kind) {
  return kind == TokenKind::kPlus || kind == TokenKind::kMinus || kind == TokenKind::kStar ||
         kind == TokenKind::kSlash || kind == TokenKind::kCaret;
}

}  // namespace

ExprPtr ValueParser::Make(ExprKind kind, std::uint32_t begin) const {
  auto expr = std::make_unique<Expr>();
  expr->kind = kind;
  expr->span = cursor_.SpanFrom(begin);
  return expr;
}

ExprPtr ValueParser::Finish(ExprPtr expr, const text::Span& fault) {
  int below = 0;
  const auto look = [&](const ExprPtr& part) {
    if (part) below = std::max(below, part->height);
  };
  for (const ExprPtr& item : expr->items) look(item);
  for (const Argument& argument : expr->arguments) {
    look(argument.value);
    look(argument.weight);
  }
  if (expr->until) below = std::max(below, expr->until->height);
  expr->height = below + 1;
  if (!cursor_.FitsDepth(expr->height, fault)) return nullptr;
  expr->span = cursor_.SpanFrom(expr->span.begin);
  return expr;
}

ExprPtr ValueParser::MakeBinary(const Token& op, ExprPtr left, ExprPtr right) {
  ExprPtr expr = Make(ExprKind::kBinary, left->span.begin);
  expr->op = op.kind == TokenKind::kPlus    ? '+'
             : op.kind == TokenKind::kMinus ? '-'
             : op.kind == TokenKind::kStar  ? '*'
             : op.kind == TokenKind::kSlash ? '/'
                                            : '^';
  expr->items.push_back(std::move(left));
  expr->items.push_back(std::move(right));
  return Finish(std::move(expr), cursor_.SpanOf(op));
}

void ValueParser::ReportMissingValue() {
  const Token& token = cursor_.Peek();
  if (token.faulty) return;
  const Token& before = cursor_.Previous();
  const bool dangling = IsOperator(before.kind) || before.kind == TokenKind::kAssign ||
                        before.kind == TokenKind::kColon || before.kind == TokenKind::kDots;
  if (dangling) {
    if (!before.faulty)
      cursor_.Report(kMissingValue, cursor_.SpanOf(before),
                     cursor_.Quote(before) + " needs a value after it");
    return;
  }
  const bool line_end = token.kind == TokenKind::kNewline;
  const text::Span span =
      line_end ? text::Span{&cursor_.source(), before.end, before.end} : cursor_.SpanOf(token);
  cursor_.Report(kMissingValue, span,
                 text::Concat({"expected a value here, not ", cursor_.Describe(token)}));
}

ExprPtr ValueParser::ParseValue() {
  if (cursor_.At(TokenKind::kText)) return ParseText();
  if (cursor_.At(TokenKind::kPath) && AtLabel(1)) return ParseBareCall();
  ExprPtr first = ParseSum();
  return first ? FinishValue(std::move(first)) : nullptr;
}

ExprPtr ValueParser::ParseText() {
  const Token token = cursor_.Take();
  if (IsOperator(cursor_.Peek().kind) || cursor_.At(TokenKind::kDots)) {
    cursor_.Report(kTextInSum, cursor_.SpanOf(token), "a text cannot be used in arithmetic");
    return nullptr;
  }
  ExprPtr expr = Make(ExprKind::kText, token.begin);
  expr->text = TextContents(cursor_.Text(token));
  return expr;
}

ExprPtr ValueParser::FinishValue(ExprPtr first) {
  if (cursor_.At(TokenKind::kDots)) return FinishRange(std::move(first));
  if (!cursor_.At(TokenKind::kColon)) return first;
  std::vector<ExprPtr> parts;
  parts.push_back(std::move(first));
  return FinishRatio(std::move(parts));
}

// Parses the rest of a ratio after its first parts, each part after its colon.
ExprPtr ValueParser::FinishRatio(std::vector<ExprPtr> parts) {
  const std::uint32_t begin = parts.front()->span.begin;
  while (cursor_.At(TokenKind::kColon)) {
    cursor_.Take();
    ExprPtr part = ParseSum();
    if (!part) return nullptr;
    parts.push_back(std::move(part));
  }
  ExprPtr ratio = Make(ExprKind::kRatio, begin);
  if (parts.size() == 2) {
    cursor_.Report(kRatioParts, ratio->span, "a ratio has three parts, but this one has 2",
                   "a range is written with '..', a ratio as 1 : y : z");
    // Most likely, a range was meant.
    ratio->kind = ExprKind::kRange;
  } else if (parts.size() > 3) {
    cursor_.Report(
        kRatioParts, ratio->span,
        text::Concat({"a ratio has three parts, but this one has ", std::to_string(parts.size())}),
        "a ratio is written 1 : y : z");
    parts.resize(3);
  }
  ratio->items = std::move(parts);
  return Finish(std::move(ratio), cursor_.SpanFrom(begin));
}

ExprPtr ValueParser::FinishRange(ExprPtr first) {
  const Token dots = cursor_.Take();
  ExprPtr range = Make(ExprKind::kRange, first->span.begin);
  ExprPtr last = ParseSum();
  if (!last) return nullptr;
  range->items.push_back(std::move(first));
  range->items.push_back(std::move(last));
  for (RangeWord word = RangeWord::kTaken; word != RangeWord::kNone;) {
    word = TakeRangeWord(*range);
    if (word == RangeWord::kFailed) return nullptr;
  }
  return Finish(std::move(range), cursor_.SpanOf(dots));
}

namespace {

struct RangeForm {
  std::string_view word;
  RangeKind kind;
};
constexpr RangeForm kRangeForms[] = {{"step", RangeKind::kStep},
                                     {"count", RangeKind::kCount},
                                     {"sobol", RangeKind::kSobol},
                                     {"latin", RangeKind::kLatin}};

}  // namespace

/// Parses `step d`, `count n`, `sobol n`, `latin n` or `log` after a range, or a word that was
/// meant as one of these.
ValueParser::RangeWord ValueParser::TakeRangeWord(Expr& range) {
  const Token token = cursor_.Peek();
  if (token.kind == TokenKind::kDots) {
    if (!token.faulty)
      cursor_.Report(kBadRange, cursor_.SpanOf(token), "a range can have only one '..'",
                     "a step follows the word: a .. b step d");
    cursor_.Take();
    return ParseSum() ? RangeWord::kTaken : RangeWord::kFailed;
  }
  if (token.kind != TokenKind::kPath) return RangeWord::kNone;
  const std::string_view word = cursor_.Text(token);
  const bool known = word == "log" || std::ranges::find(kRangeForms, word, &RangeForm::word) !=
                                          std::end(kRangeForms);
  std::string_view meant = word;
  if (!known) {
    meant = word == "by" ? "step" : DidYouMean(word, {"step", "count", "sobol", "latin", "log"});
    const bool follows =
        meant == "log" || cursor_.AtValueStart(1) || cursor_.Peek(1).kind == TokenKind::kMinus;
    if (meant.empty() || !follows || word == "as") return RangeWord::kNone;
    cursor_.Report(kBadRange, cursor_.SpanOf(token),
                   text::Concat({"a range has no word ", cursor_.Quote(token)}),
                   text::Concat({"did you mean '", meant, "'?"}));
  }
  cursor_.Take();
  if (meant != "log") return ParseRangeNumber(range, token, meant);
  const bool is_log_alone = is_log_alone_ && range.range == RangeKind::kByOne;
  if (is_log_alone || (range.range != RangeKind::kByOne && range.range != RangeKind::kStep))
    range.is_log = true;
  else if (known)
    cursor_.Report(kBadRange, cursor_.SpanOf(token), "'log' needs the number of values",
                   "write: a .. b count n log");
  return RangeWord::kTaken;
}

/// Parses the number after `word`, which is one of kRangeForms or meant as one.
ValueParser::RangeWord ValueParser::ParseRangeNumber(Expr& range, const Token& word,
                                                     std::string_view meant) {
  if (cursor_.AtStatementEnd() || AtClose() || cursor_.At(TokenKind::kComma)) {
    cursor_.Report(kMissingValue, cursor_.SpanOf(word),
                   cursor_.Quote(word) + " needs a number after it");
    return RangeWord::kTaken;
  }
  ExprPtr item = ParseSum();
  if (!item) return RangeWord::kFailed;
  if (range.items.size() == 3) {
    if (cursor_.Text(word) == meant)
      cursor_.Report(kBadRange, cursor_.SpanOf(word),
                     "a range can have one of 'step', 'count', 'sobol' and 'latin'");
    return RangeWord::kTaken;
  }
  range.range = std::ranges::find(kRangeForms, meant, &RangeForm::word)->kind;
  range.items.push_back(std::move(item));
  return RangeWord::kTaken;
}

ExprPtr ValueParser::ParseSum() {
  ExprPtr left = ParseProduct();
  while (left && (cursor_.At(TokenKind::kPlus) || cursor_.At(TokenKind::kMinus))) {
    const Token op = cursor_.Take();
    ExprPtr right = ParseProduct();
    left = right ? MakeBinary(op, std::move(left), std::move(right)) : nullptr;
  }
  return left;
}

// A unit applies to the whole product before it, so that `1/60 s` is a sixtieth of a second; after
// a quantity it applies to the last factor: `20 cm / 4 cm`.
ExprPtr ValueParser::ParseProduct() {
  ExprPtr left = ParsePower();
  bool has_unit = left && AtUnit();
  if (has_unit) left = FinishQuantity(std::move(left));
  while (left && (cursor_.At(TokenKind::kStar) || cursor_.At(TokenKind::kSlash))) {
    const Token op = cursor_.Take();
    ExprPtr right = ParsePower();
    if (right && has_unit && AtUnit()) right = FinishQuantity(std::move(right));
    left = right ? MakeBinary(op, std::move(left), std::move(right)) : nullptr;
    if (!left || has_unit || !AtUnit()) continue;
    left = FinishQuantity(std::move(left));
    has_unit = true;
  }
  return left;
}

bool ValueParser::AtUnit() const {
  const Token& before = cursor_.Previous();
  const bool can_have_one = before.kind == TokenKind::kNumber ||
                            before.kind == TokenKind::kRightParen ||
                            before.kind == TokenKind::kRightBracket;
  return can_have_one && cursor_.At(TokenKind::kPath) &&
         text::IsUnitName(cursor_.Text(cursor_.Peek()));
}

ExprPtr ValueParser::FinishQuantity(ExprPtr value) {
  const Token first = cursor_.Peek();
  const auto at_name = [this](std::size_t ahead) {
    const Token& token = cursor_.Peek(ahead);
    return token.kind == TokenKind::kPath && text::IsUnitName(cursor_.Text(token));
  };
  std::string unit;
  while (true) {
    unit += cursor_.Text(cursor_.Take());
    if (cursor_.At(TokenKind::kCaret) && !TakePower(unit)) return nullptr;
    if (cursor_.At(TokenKind::kSlash) && at_name(1)) {
      cursor_.Take();
      unit += '/';
    } else if (at_name(0)) {
      unit += ' ';
    } else {
      break;
    }
  }
  ExprPtr quantity = Make(ExprKind::kQuantity, value->span.begin);
  quantity->text = std::move(unit);
  quantity->text_span = cursor_.SpanFrom(first.begin);
  quantity->items.push_back(std::move(value));
  const text::Span fault = quantity->text_span;
  return Finish(std::move(quantity), fault);
}

/// Parses `^2` after the name of a unit; false after a report.
bool ValueParser::TakePower(std::string& unit) {
  const Token caret = cursor_.Take();
  const std::string_view power =
      cursor_.At(TokenKind::kNumber) ? cursor_.Text(cursor_.Peek()) : std::string_view();
  if (power.size() != 1 || power == "0") {
    cursor_.Report(kWrittenUnit, cursor_.SpanOf(caret),
                   "the power of a unit must be a whole number from 1 to 9",
                   "write m/s^2, or put the value in parentheses: (5 cm)^x");
    return false;
  }
  cursor_.Take();
  unit += text::Concat({"^", power});
  return true;
}

ExprPtr ValueParser::ParsePower() {
  ExprPtr base = ParseUnary();
  if (!base || !cursor_.At(TokenKind::kCaret)) return base;
  const Token op = cursor_.Take();
  ExprPtr exponent;
  {
    const DepthScope deeper(cursor_);
    if (!cursor_.FitsDepth(1, cursor_.SpanOf(op))) return nullptr;
    exponent = ParsePower();
  }
  return exponent ? MakeBinary(op, std::move(base), std::move(exponent)) : nullptr;
}

ExprPtr ValueParser::ParseUnary() {
  // One sign at most; the rest of a row of signs is one error.
  const Token sign = cursor_.Peek();
  if (sign.kind != TokenKind::kMinus && sign.kind != TokenKind::kPlus) return ParsePrimary();
  cursor_.Take();
  if (cursor_.At(TokenKind::kMinus) || cursor_.At(TokenKind::kPlus)) {
    while (cursor_.At(TokenKind::kMinus) || cursor_.At(TokenKind::kPlus)) cursor_.Take();
    cursor_.Report(kBadSign, cursor_.SpanFrom(sign.begin), "a value can have only one sign",
                   "put the inner one in parentheses: -(-5)");
  } else if (sign.kind == TokenKind::kPlus) {
    cursor_.Report(kBadSign, cursor_.SpanOf(sign), "a value cannot begin with '+'",
                   "remove it: a value without a sign is positive");
  }
  ExprPtr operand = ParsePrimary();
  if (!operand || sign.kind == TokenKind::kPlus) return operand;
  ExprPtr expr = Make(ExprKind::kNegate, sign.begin);
  expr->items.push_back(std::move(operand));
  return Finish(std::move(expr), cursor_.SpanOf(sign));
}

ExprPtr ValueParser::ParsePrimary() {
  if (IsOperator(cursor_.Previous().kind) && cursor_.NextLineContinues()) {
    cursor_.Report(kLineBreak, cursor_.SpanOf(cursor_.Previous()),
                   text::Concat({"a line cannot break after ", cursor_.Quote(cursor_.Previous())}),
                   "only after ',' in a list; otherwise, write the value on one line");
    cursor_.Take();
  }
  switch (cursor_.Peek().kind) {
    case TokenKind::kNumber: {
      const Token token = cursor_.Take();
      ExprPtr expr = Make(ExprKind::kNumber, token.begin);
      expr->text = cursor_.Text(token);
      return expr;
    }
    case TokenKind::kPath:
      return ParsePath();
    case TokenKind::kLeftParen:
    case TokenKind::kLeftBracket:
      return ParseBracketed();
    case TokenKind::kText: {
      const Token token = cursor_.Take();
      if (!token.faulty)
        cursor_.Report(kTextInSum, cursor_.SpanOf(token),
                       "a text is not allowed here; expected a number or a name",
                       "names such as sphere and dbvt are written without quotes");
      ExprPtr expr = Make(ExprKind::kPath, token.begin);
      expr->text = TextContents(cursor_.Text(token));
      return expr;
    }
    default:
      ReportMissingValue();
      return nullptr;
  }
}

ExprPtr ValueParser::ParsePath() {
  const Token token = cursor_.Take();
  if (!token.faulty)
    cursor_.RefuseReserved({std::string(cursor_.Text(token)), cursor_.SpanOf(token)});
  const bool adjacent_bracket =
      cursor_.At(TokenKind::kLeftBracket) && cursor_.Peek().begin == token.end;
  if (cursor_.At(TokenKind::kLeftParen) || adjacent_bracket) return ParseCall(token);
  ExprPtr expr = Make(ExprKind::kPath, token.begin);
  expr->text = cursor_.Text(token);
  return expr;
}

}  // namespace cdb::dsl
