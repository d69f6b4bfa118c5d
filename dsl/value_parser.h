// Values and conditions: the right-hand sides of the language.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "dsl/syntax.h"
#include "dsl/token_cursor.h"

namespace cdb::dsl {

/// Every function reports what is wrong and gives null where nothing could be understood; the
/// cursor then stands inside the statement, and whoever called skips to its end.
class ValueParser {
 public:
  explicit ValueParser(TokenCursor& cursor) : cursor_(cursor) {}

  /// `value` of the grammar: a sum, a ratio, a range, a text or a bare call.
  ExprPtr ParseValue();
  /// `condition`: the whole of it.
  ConditionPtr ParseCondition();
  /// Whether `name :` stands `ahead`: an argument, unless a ratio begins with a name.
  bool AtLabel(std::size_t ahead = 0) const;
  /// Takes an `as name` that names nothing.
  void ReportMisplacedAs();

 private:
  ExprPtr ParseSum();
  ExprPtr ParseProduct();
  /// Whether a unit can stand at the cursor, and does: `ms` behind `10` or `)`.
  bool AtUnit() const;
  /// `value` with the unit at the cursor.
  ExprPtr FinishQuantity(ExprPtr value);
  bool TakePower(std::string& unit);
  ExprPtr ParsePower();
  ExprPtr ParseUnary();
  ExprPtr ParsePrimary();
  ExprPtr ParseBracketed();
  ExprPtr ParseCall(const Token& name);
  bool ParseLimits(Expr& call);
  bool ParseArgument(Expr& call);
  bool ParseLabelled(Argument& argument);
  /// `ring radius: 20`: a call with one argument, without brackets.
  ExprPtr ParseBareCall();
  ExprPtr ParseText();
  ExprPtr ParsePath();
  /// What may follow a first sum.
  ExprPtr FinishValue(ExprPtr first);
  ExprPtr FinishRatio(std::vector<ExprPtr> parts);
  ExprPtr FinishRange(ExprPtr first);
  enum class RangeWord { kTaken, kNone, kFailed };
  RangeWord TakeRangeWord(Expr& range);
  RangeWord ParseRangeNumber(Expr& range, const Token& word, bool is_step, bool known);

  ConditionPtr ParseAnd();
  ConditionPtr ParseOperand();
  ConditionPtr ParseNot();
  ConditionPtr ParseBracketedCondition();
  ConditionPtr ParseComparison();
  ConditionPtr ParseIn(ConditionPtr condition);
  bool ParseInList(const Token& word, std::vector<ExprPtr>& values);
  /// At `in (`.
  bool AtIn(std::size_t ahead) const {
    return cursor_.AtWord("in", ahead) && cursor_.Peek(ahead + 1).kind == TokenKind::kLeftParen;
  }
  bool AtComparison() const;
  /// Where a comparison, or a side of it, cannot go on.
  bool AtComparisonEnd() const;
  void ReportMissingComparison();
  bool AtAnd() const { return cursor_.At(TokenKind::kAnd) || cursor_.AtWord("and"); }
  bool AtOr() const { return cursor_.At(TokenKind::kOr) || cursor_.AtWord("or"); }
  bool AtNot() const { return cursor_.At(TokenKind::kNot) || cursor_.AtWord("not"); }
  /// Whether the bracket at the cursor groups conditions, not numbers.
  bool BracketHoldsCondition() const;

  /// A list in brackets, the first of which was just taken. `parse_one` gives false where it could
  /// not go on; the rest of the list is still read. False where the list's end was not found.
  template <typename ParseOne>
  bool ParseList(const Token& open, ParseOne parse_one);
  /// Takes the closing bracket of `open`; false, with a report, where it is not there.
  bool Close(const Token& open, std::string_view expected);
  bool AtClose() const {
    return cursor_.At(TokenKind::kRightParen) || cursor_.At(TokenKind::kRightBracket);
  }
  /// To the next `,` or closing bracket of this list, or to the end of the statement.
  void SkipElement();
  Token TakeOpen();

  ExprPtr Make(ExprKind kind, std::uint32_t begin) const;
  /// Sets span and height from the parts; null, with a report, where it nests too deep.
  ExprPtr Finish(ExprPtr expr, const text::Span& fault);
  ExprPtr MakeBinary(const Token& op, ExprPtr left, ExprPtr right);
  ConditionPtr MakeLogic(ConditionKind kind, const text::Span& fault, ConditionPtr left,
                         ConditionPtr right);
  void ReportMissingValue();

  TokenCursor& cursor_;
  bool bracketed_ = false;  // whether the condition parsed last stands in brackets of its own
};

}  // namespace cdb::dsl
