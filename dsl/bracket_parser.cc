// Values with brackets: vectors, and calls with their arguments.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/lexer.h"
#include "dsl/text/concat.h"
#include "dsl/value_parser.h"

namespace cdb::dsl {
namespace {

bool IsName(std::string_view path) { return path.find('.') == std::string_view::npos; }

bool IsFind(const Expr& call) { return call.text == "find"; }

}  // namespace

Token ValueParser::TakeOpen() {
  const std::size_t before = cursor_.index();
  const Token open = cursor_.Take();
  if (open.kind == TokenKind::kLeftBracket)
    cursor_.Report(kSquareBracket, cursor_.SpanOf(open), "square brackets have no meaning here",
                   InsteadOfSquareBrackets(open, before));
  return open;
}

/// The remedy for a list in square brackets, whose first token is `open`, number `index`.
std::string ValueParser::InsteadOfSquareBrackets(const Token& open, std::size_t index) const {
  constexpr const char* kGeneral = "vectors and arguments are enclosed in ( )";
  const Token& before = cursor_.TokenAt(index == 0 ? 0 : index - 1);
  const bool is_call = before.kind == TokenKind::kPath && before.end == open.begin;
  std::size_t count = 1, ahead = 0;
  for (; cursor_.Peek(ahead).kind != TokenKind::kRightBracket; ++ahead) {
    const TokenKind kind = cursor_.Peek(ahead).kind;
    const bool is_simple = kind == TokenKind::kNumber || kind == TokenKind::kPath ||
                           kind == TokenKind::kMinus || kind == TokenKind::kComma;
    if (!is_simple) return kGeneral;
    count += kind == TokenKind::kComma;
  }
  if (is_call || ahead == 0) return kGeneral;
  const std::string items =
      cursor_.Excerpt({&cursor_.source(), cursor_.Peek().begin, cursor_.Peek(ahead - 1).end});
  const bool is_in_sweep = before.kind == TokenKind::kLeftParen && index >= 2 &&
                           cursor_.Text(cursor_.TokenAt(index - 2)) == "sweep";
  if (is_in_sweep) return text::Concat({"write ", items, " without brackets"});
  if (count == 3 && cursor_.Peek().kind != TokenKind::kPath)
    return text::Concat(
        {"write (", items, ") for a vector, sweep(", items, ") for one run with each"});
  return text::Concat({"for one run with each, write sweep(", items, ")"});
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
                   text::Concat({"this ", cursor_.Quote(open), " is not closed"}), "",
                   std::move(notes));
    return false;
  }
  cursor_.ReportUnexpected(expected);
  return false;
}

void ValueParser::ReportMisplacedAs() {
  const Token as = cursor_.Take();
  if (cursor_.At(TokenKind::kPath)) cursor_.Take();
  if (cursor_.At(TokenKind::kText)) cursor_.Take();
  cursor_.Report(kMisplacedAs, cursor_.SpanFrom(as.begin), "'as' can only follow a ')'",
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
      // Do not read an element again if it goes on with an operator.
      if (!cursor_.AtValueStart()) SkipElement();
    }
    if (cursor_.At(TokenKind::kComma)) {
      const Token comma = cursor_.Take();
      if (AtClose())
        cursor_.Report(kTrailingComma, cursor_.SpanOf(comma), "no value follows this ','",
                       "remove it");
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
                     text::Concat({"a ',' is missing before ", cursor_.Quote(cursor_.Peek())}));
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
      cursor_.Report(
          kBracketedValue, item->span, std::string(what) + " is not allowed in plain parentheses",
          item->kind == ExprKind::kRange ? "write sweep(a .. b), or remove the parentheses" : "");
    }
    all_good &= item != nullptr;
    const bool good = item != nullptr;
    if (good) items.push_back(std::move(item));
    return good;
  });
  if (!closed) return nullptr;
  const text::Span span = cursor_.SpanFrom(open.begin);
  if (items.empty()) {
    if (all_good) cursor_.Report(kMissingValue, span, "these parentheses are empty");
    return nullptr;
  }
  if (items.size() == 1) {
    ExprPtr inner = std::move(items.front());
    inner->span = span;
    return inner;
  }
  if (items.size() != 3 && all_good)
    cursor_.Report(kVectorParts, span,
                   text::Concat({"a vector has three components, but this one has ",
                                 std::to_string(items.size())}),
                   text::Concat({"for one run with each value, write sweep(",
                                 cursor_.Excerpt(Join(items.front()->span, items.back()->span)),
                                 "); a vector is written (x, y, z)"}));
  ExprPtr vector = Make(ExprKind::kVector, open.begin);
  vector->items = std::move(items);
  return Finish(std::move(vector), cursor_.SpanOf(open));
}

/// Parses the values after `word`, which is `in`.
bool ValueParser::ParseInList(const Token& word, std::vector<ExprPtr>& values) {
  if (!cursor_.At(TokenKind::kLeftParen) && !cursor_.At(TokenKind::kLeftBracket)) {
    cursor_.Report(kMissingValue, cursor_.SpanOf(word),
                   "'in' must be followed by a list in parentheses",
                   "for example: detector in (sap, dbvt)");
    return false;
  }
  const DepthScope deeper(cursor_);
  const Token open = TakeOpen();
  if (!cursor_.FitsDepth(1, cursor_.SpanOf(open))) return false;
  bool all_good = true;
  const bool closed = ParseList(open, [&] {
    ExprPtr value = ParseSum();
    all_good &= value != nullptr;
    if (value) values.push_back(std::move(value));
    return all_good;
  });
  if (closed && all_good && values.empty())
    cursor_.Report(kMissingValue, cursor_.SpanFrom(open.begin), "these parentheses are empty");
  return closed && all_good && !values.empty();
}

ExprPtr ValueParser::ParseCall(const Token& name) {
  ExprPtr call = Make(ExprKind::kCall, name.begin);
  call->text = cursor_.Text(name);
  if (!name.faulty && !IsName(call->text))
    cursor_.Report(kBadName, cursor_.SpanOf(name), "the name of a function cannot contain '.'");
  {
    const DepthScope deeper(cursor_);
    const Token open = TakeOpen();
    if (!cursor_.FitsDepth(1, cursor_.SpanOf(open))) return nullptr;
    const bool outer = std::exchange(is_log_alone_, IsFind(*call));
    const bool is_read = ParseList(open, [&] { return ParseArgument(*call); });
    is_log_alone_ = outer;
    if (!is_read) return nullptr;
  }
  if (cursor_.AtWord("as") && !ParseAxisName(*call)) return nullptr;
  // `in (a, b)` is part of a condition.
  const bool has_limits = cursor_.AtWord("in") && cursor_.Peek(1).kind != TokenKind::kLeftParen;
  if (has_limits && !ParseLimits(*call)) return nullptr;
  return Finish(std::move(call), cursor_.SpanOf(name));
}

/// Parses `as z`, `as "number of layers"` or `as z "number of layers"` after a call. False, with a
/// report, if it is incomplete.
bool ValueParser::ParseAxisName(Expr& call) {
  const Token as = cursor_.Take();
  const bool has_name = !cursor_.At(TokenKind::kText);
  if (has_name) call.axis = cursor_.ParseName("an axis", /*within_value=*/true);
  if (has_name && !call.axis) {
    cursor_.Report(kMissingName, cursor_.SpanOf(as),
                   "'as' must be followed by the name or the title of the axis",
                   "for example: sweep(1 .. 5) as z, or as \"number of layers\"");
    return false;
  }
  if (cursor_.At(TokenKind::kText)) call.axis_title = TextContents(cursor_.Text(cursor_.Take()));
  return true;
}

/// Parses `in 2 .. 8` after a call. False, with a report, if it is incomplete.
bool ValueParser::ParseLimits(Expr& call) {
  const Token in = cursor_.Take();
  ExprPtr least = ParseSum();
  if (!least) return false;
  if (!cursor_.At(TokenKind::kDots)) {
    cursor_.Report(kBadRange, cursor_.SpanFrom(in.begin), "'in' needs two limits",
                   "for example: normal(5, 1) in 2 .. 8");
    return false;
  }
  cursor_.Take();
  ExprPtr most = ParseSum();
  if (!most) return false;
  call.items.push_back(std::move(least));
  call.items.push_back(std::move(most));
  return true;
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
    cursor_.Report(kBadName, function.span, "the name of a function cannot contain '.'");
  const Token label = cursor_.Take();
  cursor_.Take();
  Argument argument;
  argument.name = Name{std::string(cursor_.Text(label)), cursor_.SpanOf(label)};
  cursor_.RefuseReserved(*argument.name);
  // Not a bare call again: in `ring radius: r gap: 2` the brackets are missing.
  if (cursor_.At(TokenKind::kText)) {
    argument.value = ParseText();
  } else if (ExprPtr first = ParseSum()) {
    argument.value = FinishValue(std::move(first));
  }
  if (!argument.value) return nullptr;
  call->arguments.push_back(std::move(argument));
  return Finish(std::move(call), cursor_.SpanOf(name));
}

/// Parses an argument that begins with `name :`. Its value is null if it is missing.
bool ValueParser::ParseLabelled(Argument& argument) {
  const Token first = cursor_.Take();
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
  return true;
}

bool ValueParser::AtUntil(const Expr& call) const {
  return (IsFind(call) || call.text == "sweep") && AtLabel() && cursor_.AtWord("until");
}

/// Parses `until: verdict != stable`.
bool ValueParser::ParseUntil(Expr& call) {
  const Token word = cursor_.Take();
  cursor_.Take();
  ConditionPtr condition = ParseCondition();
  if (!condition) return false;
  if (call.until)
    cursor_.Report(kTwoValues, cursor_.SpanOf(word), "find() has one condition",
                   "write a benchmark for each");
  call.until = std::move(condition);
  call.until_span = cursor_.SpanOf(word);
  return true;
}

// Parses `sd: 3`, `1 : y : z`, `y : 1 : 1` or `sphere 3`. The number of colons tells a ratio that
// begins with a name from a named argument.
bool ValueParser::ParseArgument(Expr& call) {
  if (AtUntil(call)) return ParseUntil(call);
  Argument argument;
  const Token& sign = cursor_.Peek(1);
  if (cursor_.At(TokenKind::kPath) && sign.kind == TokenKind::kAssign) {
    const Token name = cursor_.Take();
    const Token equals = cursor_.Take();
    cursor_.Report(
        kEqualsInSetting, cursor_.SpanOf(equals), "an argument with a name is written with ':'",
        text::Concat({"write ", cursor_.Text(name), ": ", cursor_.Text(cursor_.Peek())}));
    argument.name = Name{std::string(cursor_.Text(name)), cursor_.SpanOf(name)};
    argument.value = ParseValue();
  } else if (!AtLabel()) {
    argument.value = ParseValue();
  } else if (!ParseLabelled(argument)) {
    return false;
  }
  if (!argument.value) return false;
  const bool weighable = call.text == "any" || argument.value->kind == ExprKind::kCall ||
                         (argument.value->kind == ExprKind::kPath && IsName(argument.value->text));
  if (weighable && cursor_.At(TokenKind::kNumber)) argument.weight = ParsePrimary();
  call.arguments.push_back(std::move(argument));
  return true;
}

}  // namespace cdb::dsl
