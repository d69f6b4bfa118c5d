// The parser of conditions, part of ValueParser.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "dsl/diagnostics.h"
#include "dsl/text/concat.h"
#include "dsl/value_parser.h"

namespace cdb::dsl {
namespace {

std::string_view ComparisonOf(TokenKind kind) {
  switch (kind) {
    case TokenKind::kNotEqual:
      return "!=";
    case TokenKind::kLess:
      return "<";
    case TokenKind::kLessEqual:
      return "<=";
    case TokenKind::kGreater:
      return ">";
    case TokenKind::kGreaterEqual:
      return ">=";
    default:
      return "==";
  }
}

}  // namespace

ConditionPtr ValueParser::MakeLogic(ConditionKind kind, const text::Span& fault, ConditionPtr left,
                                    ConditionPtr right) {
  auto condition = std::make_unique<Condition>();
  condition->kind = kind;
  condition->span = cursor_.SpanFrom(right ? left->span.begin : fault.begin);
  condition->height = 1 + std::max(left->height, right ? right->height : 0);
  condition->items.push_back(std::move(left));
  if (right) condition->items.push_back(std::move(right));
  bracketed_ = false;
  if (!cursor_.FitsDepth(condition->height, fault)) return nullptr;
  return condition;
}

ConditionPtr ValueParser::ParseCondition() {
  return ParseLogic(ConditionKind::kOr, &ValueParser::AtOr, &ValueParser::ParseAnd);
}

ConditionPtr ValueParser::ParseAnd() {
  return ParseLogic(ConditionKind::kAnd, &ValueParser::AtAnd, &ValueParser::ParseOperand);
}

ConditionPtr ValueParser::ParseLogic(ConditionKind kind, bool (ValueParser::*at_operator)() const,
                                     ConditionPtr (ValueParser::*parse)()) {
  ConditionPtr left = (this->*parse)();
  while (left && (this->*at_operator)()) {
    const Token op = cursor_.Take();
    ConditionPtr right = (this->*parse)();
    left = right ? MakeLogic(kind, cursor_.SpanOf(op), std::move(left), std::move(right)) : nullptr;
  }
  return left;
}

ConditionPtr ValueParser::ParseOperand() {
  if (AtNot()) return ParseNot();
  if (cursor_.At(TokenKind::kLeftParen) && BracketHoldsCondition())
    return ParseBracketedCondition();
  return ParseComparison();
}

// In the grammar, `not` negates the whole condition after it. In many languages it binds closer, so
// a use where this makes a difference is reported.
ConditionPtr ValueParser::ParseNot() {
  const DepthScope deeper(cursor_);
  const Token word = cursor_.Take();
  if (!cursor_.FitsDepth(1, cursor_.SpanOf(word))) return nullptr;
  ConditionPtr operand = ParseCondition();
  if (!operand) return nullptr;
  const bool several = operand->kind == ConditionKind::kAnd || operand->kind == ConditionKind::kOr;
  if (several && !bracketed_)
    cursor_.Report(kNotScope, cursor_.SpanOf(word), "this 'not' negates everything that follows",
                   "put the part to negate in parentheses");
  return MakeLogic(ConditionKind::kNot, cursor_.SpanOf(word), std::move(operand), nullptr);
}

ConditionPtr ValueParser::ParseBracketedCondition() {
  const DepthScope deeper(cursor_);
  const Token open = cursor_.Take();
  if (!cursor_.FitsDepth(1, cursor_.SpanOf(open))) return nullptr;
  ConditionPtr inner = ParseCondition();
  if (!inner || !Close(open, "'and', 'or' or ')'")) return nullptr;
  inner->span = cursor_.SpanFrom(open.begin);
  bracketed_ = true;
  return inner;
}

bool ValueParser::BracketHoldsCondition() const {
  int depth = 0;
  for (std::size_t ahead = 0;; ++ahead) {
    const TokenKind kind = cursor_.Peek(ahead).kind;
    switch (kind) {
      case TokenKind::kLeftParen:
        ++depth;
        break;
      case TokenKind::kRightParen:
        if (--depth == 0) return false;
        break;
      case TokenKind::kAssign:
      case TokenKind::kEqual:
      case TokenKind::kNotEqual:
      case TokenKind::kLess:
      case TokenKind::kLessEqual:
      case TokenKind::kGreater:
      case TokenKind::kGreaterEqual:
      case TokenKind::kAnd:
      case TokenKind::kOr:
      case TokenKind::kNot:
        return true;
      case TokenKind::kPath:
        if (cursor_.AtWord("and", ahead) || cursor_.AtWord("or", ahead) ||
            cursor_.AtWord("not", ahead) || AtIn(ahead))
          return true;
        break;
      case TokenKind::kNewline:
      case TokenKind::kSemicolon:
      case TokenKind::kLeftBrace:
      case TokenKind::kRightBrace:
      case TokenKind::kEnd:
        return false;
      default:
        break;
    }
  }
}

bool ValueParser::AtComparison() const {
  switch (cursor_.Peek().kind) {
    case TokenKind::kAssign:
    case TokenKind::kEqual:
    case TokenKind::kNotEqual:
    case TokenKind::kLess:
    case TokenKind::kLessEqual:
    case TokenKind::kGreater:
    case TokenKind::kGreaterEqual:
      return true;
    default:
      return false;
  }
}

bool ValueParser::AtComparisonEnd() const {
  return AtAnd() || AtOr() || AtClose() || cursor_.AtStatementEnd();
}

void ValueParser::ReportMissingComparison() {
  // Points at the word left dangling, if there is one.
  const Token& before = cursor_.Previous();
  const bool word = before.kind == TokenKind::kPath || before.kind == TokenKind::kAnd ||
                    before.kind == TokenKind::kOr || before.kind == TokenKind::kNot;
  cursor_.Report(
      kMissingComparison, cursor_.SpanOf(word ? before : cursor_.Peek()),
      word ? cursor_.Quote(before) + " needs a comparison after it"
           : text::Concat({"expected a comparison here, not ", cursor_.Describe(cursor_.Peek())}),
      "for example: quantity > 3000");
}

/// Parses `x in (a, b)` and `x not in (a, b)`, after `x`.
ConditionPtr ValueParser::ParseIn(ConditionPtr condition) {
  const Token first = cursor_.Peek();
  const bool is_negated = AtNot();
  if (is_negated) cursor_.Take();
  const Token word = cursor_.Take();
  condition->kind = ConditionKind::kIn;
  if (!ParseInList(word, condition->values)) return nullptr;
  condition->span = cursor_.SpanFrom(condition->left->span.begin);
  condition->height = 1 + condition->left->height;
  for (const ExprPtr& value : condition->values)
    condition->height = std::max(condition->height, 1 + value->height);
  bracketed_ = false;
  if (!cursor_.FitsDepth(condition->height, cursor_.SpanOf(word))) return nullptr;
  if (!is_negated) return condition;
  const text::Span span = condition->span;
  ConditionPtr negated =
      MakeLogic(ConditionKind::kNot, cursor_.SpanOf(first), std::move(condition), nullptr);
  if (negated) negated->span = span;
  return negated;
}

ConditionPtr ValueParser::ParseComparison() {
  if (AtComparisonEnd() && !cursor_.Peek().faulty) {
    ReportMissingComparison();
    return nullptr;
  }
  auto condition = std::make_unique<Condition>();
  condition->left = ParseSum();
  if (!condition->left) return nullptr;
  if (cursor_.AtWord("in") || (AtNot() && cursor_.AtWord("in", 1)))
    return ParseIn(std::move(condition));
  if (!AtComparison()) {
    if (!AtComparisonEnd()) {
      cursor_.ReportUnexpected("a comparison such as == or <");
      return nullptr;
    }
    cursor_.Report(kMissingComparison, condition->left->span,
                   cursor_.Quote(condition->left->span) + " alone is not a condition",
                   "compare it with a value: detector == simple");
    return nullptr;
  }
  const Token op = cursor_.Take();
  if (op.kind == TokenKind::kAssign && !op.faulty)
    cursor_.Report(kSingleEquals, cursor_.SpanOf(op), "a comparison is written '=='",
                   "did you mean '=='?");
  condition->op = ComparisonOf(op.kind);
  if (AtComparisonEnd()) {
    cursor_.Report(kMissingValue, cursor_.SpanOf(op),
                   cursor_.Quote(op) + " needs a value after it");
    return nullptr;
  }
  condition->right = ParseSum();
  if (!condition->right) return nullptr;
  while (AtComparison()) {
    const Token second = cursor_.Take();
    if (!second.faulty)
      cursor_.Report(kChainedComparison, cursor_.SpanOf(second), "comparisons do not chain",
                     "join two of them: a < n and n < b");
    if (!ParseSum()) return nullptr;
  }
  condition->span = cursor_.SpanFrom(condition->left->span.begin);
  condition->height = 1 + std::max(condition->left->height, condition->right->height);
  bracketed_ = false;
  if (!cursor_.FitsDepth(condition->height, cursor_.SpanOf(op))) return nullptr;
  return condition;
}

}  // namespace cdb::dsl
