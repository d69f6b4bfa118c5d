#include "dsl/value_parser.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dsl/concat.h"
#include "dsl/diagnostic_kinds.h"

namespace cdb::dsl {
namespace {

bool IsOperator(TokenKind kind) {
  return kind == TokenKind::kPlus || kind == TokenKind::kMinus || kind == TokenKind::kStar ||
         kind == TokenKind::kSlash || kind == TokenKind::kCaret;
}

bool IsName(std::string_view path) { return path.find('.') == std::string_view::npos; }

}  // namespace

ExprPtr ValueParser::Make(ExprKind kind, std::uint32_t begin) const {
  auto expr = std::make_unique<Expr>();
  expr->kind = kind;
  expr->span = cursor_.SpanFrom(begin);
  return expr;
}

ExprPtr ValueParser::Finish(ExprPtr expr, const Span& fault) {
  int below = 0;
  const auto look = [&](const ExprPtr& part) {
    if (part) below = std::max(below, part->height);
  };
  for (const ExprPtr& item : expr->items) look(item);
  for (const Argument& argument : expr->arguments) {
    look(argument.value);
    look(argument.weight);
  }
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
  const Span span =
      line_end ? Span{&cursor_.source(), before.end, before.end} : cursor_.SpanOf(token);
  cursor_.Report(kMissingValue, span,
                 Concat({"expected a value here, not ", cursor_.Describe(token)}));
}

// ------------------------------------------------------------------------------------- values

ExprPtr ValueParser::ParseValue() {
  if (cursor_.At(TokenKind::kText)) return ParseText();
  if (cursor_.At(TokenKind::kPath) && AtLabel(1)) return ParseBareCall();
  ExprPtr first = ParseSum();
  return first ? FinishValue(std::move(first)) : nullptr;
}

ExprPtr ValueParser::ParseText() {
  const Token token = cursor_.Take();
  if (IsOperator(cursor_.Peek().kind) || cursor_.At(TokenKind::kDots)) {
    cursor_.Report(kTextInSum, cursor_.SpanOf(token), "a text cannot be calculated with");
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

// The first parts of a ratio are there; the others follow, each after its colon.
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
    cursor_.Report(kRatioParts, ratio->span, "a ratio has three parts, and this has 2",
                   "a range is written with '..', a ratio as 1 : y : z");
    // A range was meant, most likely.
    ratio->kind = ExprKind::kRange;
  } else if (parts.size() > 3) {
    cursor_.Report(kRatioParts, ratio->span,
                   Concat({"a ratio has three parts, and this has ", std::to_string(parts.size())}),
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
  while (cursor_.At(TokenKind::kPath) || cursor_.At(TokenKind::kDots)) {
    const Token token = cursor_.Peek();
    const std::string_view word = cursor_.Text(token);
    if (token.kind == TokenKind::kDots) {
      if (!token.faulty)
        cursor_.Report(kBadRange, cursor_.SpanOf(token), "a range has only one '..'",
                       "a step follows the word: a .. b step d");
      cursor_.Take();
      if (!ParseSum()) return nullptr;
      continue;
    }
    const bool known = word == "step" || word == "count" || word == "log";
    std::string_view meant = word;
    if (!known) {
      meant = word == "by" ? "step" : DidYouMean(word, {"step", "count", "log"});
      const bool follows =
          meant == "log" || cursor_.AtValueStart(1) || cursor_.Peek(1).kind == TokenKind::kMinus;
      if (meant.empty() || !follows || word == "as") break;
      cursor_.Report(kBadRange, cursor_.SpanOf(token),
                     Concat({"a range knows no word ", cursor_.Quote(token)}),
                     Concat({"did you mean '", meant, "'?"}));
    }
    cursor_.Take();
    if (meant == "log") {
      if (range->range == RangeKind::kCount)
        range->range = RangeKind::kCountLog;
      else if (known)
        cursor_.Report(kBadRange, cursor_.SpanOf(token),
                       "'log' needs to know how many values there are",
                       "write: a .. b count n log");
      continue;
    }
    ExprPtr item;
    if (cursor_.AtStatementEnd() || AtClose() || cursor_.At(TokenKind::kComma)) {
      cursor_.Report(kMissingValue, cursor_.SpanOf(token),
                     cursor_.Quote(token) + " needs a number after it");
      continue;
    }
    item = ParseSum();
    if (!item) return nullptr;
    if (range->items.size() == 3) {
      if (known)
        cursor_.Report(kBadRange, cursor_.SpanOf(token),
                       "a range has one 'step' or one 'count', not both");
      continue;
    }
    range->range = meant == "step" ? RangeKind::kStep : RangeKind::kCount;
    range->items.push_back(std::move(item));
  }
  return Finish(std::move(range), cursor_.SpanOf(dots));
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

ExprPtr ValueParser::ParseProduct() {
  ExprPtr left = ParsePower();
  while (left && (cursor_.At(TokenKind::kStar) || cursor_.At(TokenKind::kSlash))) {
    const Token op = cursor_.Take();
    ExprPtr right = ParsePower();
    left = right ? MakeBinary(op, std::move(left), std::move(right)) : nullptr;
  }
  return left;
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
  // One sign at most; the rest of a row of them is one error.
  const Token sign = cursor_.Peek();
  if (sign.kind != TokenKind::kMinus && sign.kind != TokenKind::kPlus) return ParsePrimary();
  cursor_.Take();
  if (cursor_.At(TokenKind::kMinus) || cursor_.At(TokenKind::kPlus)) {
    while (cursor_.At(TokenKind::kMinus) || cursor_.At(TokenKind::kPlus)) cursor_.Take();
    cursor_.Report(kBadSign, cursor_.SpanFrom(sign.begin), "a value has one sign at most",
                   "bracket the inner one: -(-5)");
  } else if (sign.kind == TokenKind::kPlus) {
    cursor_.Report(kBadSign, cursor_.SpanOf(sign), "a value has no '+' before it",
                   "leave it out: a value without a sign is positive");
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
                   Concat({"a line cannot break after ", cursor_.Quote(cursor_.Previous())}),
                   "it can after ',' in a list; else write the value on one line");
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
                       "a text cannot stand here, where a number or a name is asked for",
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

// ----------------------------------------------------------------------------------- brackets

Token ValueParser::TakeOpen() {
  const Token open = cursor_.Take();
  if (open.kind == TokenKind::kLeftBracket)
    cursor_.Report(kSquareBracket, cursor_.SpanOf(open), "square brackets mean nothing here",
                   "vectors and arguments stand in ( )");
  return open;
}

void ValueParser::SkipElement() {
  for (int depth = 0; !cursor_.At(TokenKind::kEnd); cursor_.Take()) {
    switch (cursor_.Peek().kind) {
      case TokenKind::kNewline:
      case TokenKind::kSemicolon:
      case TokenKind::kLeftBrace:
      case TokenKind::kRightBrace:
        return;
      case TokenKind::kLeftParen:
      case TokenKind::kLeftBracket:
        ++depth;
        break;
      case TokenKind::kRightParen:
      case TokenKind::kRightBracket:
        if (depth-- == 0) return;
        break;
      case TokenKind::kComma:
        if (depth == 0) return;
        break;
      default:
        break;
    }
  }
}

bool ValueParser::Close(const Token& open, std::string_view expected) {
  if (AtClose()) {
    const Token close = cursor_.Take();
    if (open.kind == TokenKind::kLeftParen && close.kind == TokenKind::kRightBracket)
      cursor_.Report(kMismatchedBracket, cursor_.SpanOf(close), "'(' is closed by ')', not by ']'",
                     "", {{cursor_.SpanOf(open), "it was opened here"}});
    return true;
  }
  const Token& found = cursor_.Peek();
  if (cursor_.AtStatementEnd() || found.kind == TokenKind::kLeftBrace) {
    std::vector<Note> notes;
    if (found.kind == TokenKind::kNewline)
      notes.push_back({{&cursor_.source(), found.begin, found.begin},
                       "the line ends here; inside ( ) it can break after ','"});
    else
      notes.push_back({cursor_.SpanOf(found), cursor_.Describe(found) + " comes before its ')'"});
    cursor_.Report(kUnclosedBracket, cursor_.SpanOf(open),
                   Concat({"this ", cursor_.Quote(open), " is not closed"}), "", std::move(notes));
    return false;
  }
  cursor_.ReportUnexpected(expected);
  return false;
}

void ValueParser::ReportMisplacedAs() {
  const Token as = cursor_.Take();
  if (cursor_.At(TokenKind::kPath)) cursor_.Take();
  cursor_.Report(kMisplacedAs, cursor_.SpanFrom(as.begin), "'as' stands after a ')' only",
                 "for example: sweep(1 .. 5) as z");
}

template <typename ParseOne>
bool ValueParser::ParseList(const Token& open, ParseOne parse_one) {
  bool comma_reported = false;
  while (!AtClose()) {
    if (cursor_.AtStatementEnd()) return Close(open, "");
    if (!parse_one()) {
      if (cursor_.gave_up()) return false;
      SkipElement();
      if (!AtClose() && !cursor_.At(TokenKind::kComma)) return false;
    }
    if (cursor_.At(TokenKind::kNewline) && cursor_.NextLineContinues()) {
      const Token& next = cursor_.Peek(1);
      cursor_.Report(
          kLineBreak, cursor_.SpanOf(next), "inside ( ) a line can break after ',' only",
          next.kind == TokenKind::kComma ? "put the ',' at the end of the line above" : "");
      cursor_.Take();
      comma_reported = true;
      // An element that goes on with an operator is not read again.
      if (!cursor_.AtValueStart()) SkipElement();
    }
    if (cursor_.At(TokenKind::kComma)) {
      const Token comma = cursor_.Take();
      if (AtClose())
        cursor_.Report(kTrailingComma, cursor_.SpanOf(comma), "no value follows this ','",
                       "leave it out");
      continue;
    }
    if (AtClose()) break;
    if (cursor_.AtWord("as")) {
      ReportMisplacedAs();
      continue;
    }
    if (!cursor_.AtValueStart()) {
      if (Close(open, "',' or ')'")) return true;
      SkipElement();
      if (cursor_.At(TokenKind::kComma)) {
        cursor_.Take();
        continue;
      }
      if (!AtClose()) return false;
      break;
    }
    if (!comma_reported && !cursor_.Peek().faulty)
      cursor_.Report(kMissingComma, cursor_.SpanOf(cursor_.Peek()),
                     Concat({"a ',' is missing before ", cursor_.Quote(cursor_.Peek())}));
    comma_reported = true;
  }
  return Close(open, "')'");
}

ExprPtr ValueParser::ParseBracketed() {
  const DepthScope deeper(cursor_);
  const Token open = TakeOpen();
  if (!cursor_.FitsDepth(1, cursor_.SpanOf(open))) return nullptr;
  std::vector<ExprPtr> items;
  bool all_good = true;
  const bool closed = ParseList(open, [&] {
    ExprPtr item = ParseValue();
    if (item && (item->kind == ExprKind::kRange || item->kind == ExprKind::kRatio ||
                 item->kind == ExprKind::kText)) {
      const char* what = item->kind == ExprKind::kRange   ? "a range"
                         : item->kind == ExprKind::kRatio ? "a ratio"
                                                          : "a text";
      cursor_.Report(kBracketedValue, item->span,
                     std::string(what) + " cannot stand in plain brackets",
                     item->kind == ExprKind::kRange ? "write sweep(a .. b), or no brackets" : "");
    }
    all_good &= item != nullptr;
    const bool good = item != nullptr;
    if (good) items.push_back(std::move(item));
    return good;
  });
  if (!closed) return nullptr;
  const Span span = cursor_.SpanFrom(open.begin);
  if (items.empty()) {
    if (all_good) cursor_.Report(kMissingValue, span, "there is no value in these brackets");
    return nullptr;
  }
  if (items.size() == 1) {
    ExprPtr inner = std::move(items.front());
    inner->span = span;
    return inner;
  }
  if (items.size() != 3 && all_good)
    cursor_.Report(
        kVectorParts, span,
        Concat({"a vector has three parts, and this has ", std::to_string(items.size())}),
        "a vector is written (x, y, z)");
  ExprPtr vector = Make(ExprKind::kVector, open.begin);
  vector->items = std::move(items);
  return Finish(std::move(vector), cursor_.SpanOf(open));
}

ExprPtr ValueParser::ParseCall(const Token& name) {
  ExprPtr call = Make(ExprKind::kCall, name.begin);
  call->text = cursor_.Text(name);
  if (!name.faulty && !IsName(call->text))
    cursor_.Report(kBadName, cursor_.SpanOf(name), "a function's name has no '.' in it");
  {
    const DepthScope deeper(cursor_);
    const Token open = TakeOpen();
    if (!cursor_.FitsDepth(1, cursor_.SpanOf(open))) return nullptr;
    if (!ParseList(open, [&] { return ParseArgument(*call); })) return nullptr;
  }
  if (cursor_.AtWord("as")) {
    const Token as = cursor_.Take();
    call->axis = cursor_.ParseName("an axis", /*within_value=*/true);
    if (!call->axis) {
      cursor_.Report(kMissingName, cursor_.SpanOf(as), "'as' needs the axis's name after it",
                     "for example: sweep(1 .. 5) as z");
      return nullptr;
    }
  }
  return Finish(std::move(call), cursor_.SpanOf(name));
}

bool ValueParser::AtLabel(std::size_t ahead) const {
  const Token& name = cursor_.Peek(ahead);
  return name.kind == TokenKind::kPath && IsName(cursor_.Text(name)) &&
         cursor_.Peek(ahead + 1).kind == TokenKind::kColon;
}

ExprPtr ValueParser::ParseBareCall() {
  const Token name = cursor_.Take();
  ExprPtr call = Make(ExprKind::kCall, name.begin);
  call->text = cursor_.Text(name);
  call->bare = true;
  const Name function{call->text, cursor_.SpanOf(name)};
  if (!name.faulty) cursor_.RefuseReserved(function);
  if (!name.faulty && !IsName(call->text))
    cursor_.Report(kBadName, function.span, "a function's name has no '.' in it");
  const Token label = cursor_.Take();
  cursor_.Take();
  Argument argument;
  argument.name = Name{std::string(cursor_.Text(label)), cursor_.SpanOf(label)};
  cursor_.RefuseReserved(*argument.name);
  // No bare call again: in `ring radius: r gap: 2` it is the brackets that are missing.
  if (cursor_.At(TokenKind::kText)) {
    argument.value = ParseText();
  } else if (ExprPtr first = ParseSum()) {
    argument.value = FinishValue(std::move(first));
  }
  if (!argument.value) return nullptr;
  call->arguments.push_back(std::move(argument));
  return Finish(std::move(call), cursor_.SpanOf(name));
}

// `sd: 3`, `1 : y : z`, `y : 1 : 1` and `sphere 3`: how many colons there are tells a ratio that
// begins with a name from a named argument.
bool ValueParser::ParseArgument(Expr& call) {
  Argument argument;
  const Token first = cursor_.Peek();
  if (!AtLabel()) {
    argument.value = ParseValue();
  } else {
    cursor_.Take();
    cursor_.Take();
    Name name{std::string(cursor_.Text(first)), cursor_.SpanOf(first)};
    std::vector<ExprPtr> sums;
    while (true) {
      if (sums.empty() && cursor_.At(TokenKind::kText)) {
        argument.value = ParseText();
        break;
      }
      ExprPtr sum = ParseSum();
      if (!sum) return false;
      sums.push_back(std::move(sum));
      if (!cursor_.At(TokenKind::kColon) || sums.size() == 3) break;
      cursor_.Take();
    }
    cursor_.RefuseReserved(name);
    if (sums.empty()) {
      argument.name = std::move(name);
    } else if (sums.size() == 1) {
      argument.name = std::move(name);
      argument.value =
          cursor_.At(TokenKind::kDots) ? FinishRange(std::move(sums.front())) : std::move(sums[0]);
    } else if (sums.size() == 2) {
      ExprPtr part = Make(ExprKind::kPath, first.begin);
      part->span = name.span;
      part->text = std::move(name.text);
      sums.insert(sums.begin(), std::move(part));
      argument.value = FinishRatio(std::move(sums));
    } else if (sums.size() == 3) {
      argument.name = std::move(name);
      argument.value = FinishRatio(std::move(sums));
    }
  }
  if (!argument.value) return false;
  const bool weighable = argument.value->kind == ExprKind::kCall ||
                         (argument.value->kind == ExprKind::kPath && IsName(argument.value->text));
  if (weighable && cursor_.At(TokenKind::kNumber)) argument.weight = ParsePrimary();
  call.arguments.push_back(std::move(argument));
  return true;
}

}  // namespace cdb::dsl
