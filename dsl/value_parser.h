// The parser of values and conditions: the right-hand sides of the language.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "dsl/syntax.h"
#include "dsl/token_cursor.h"

namespace cdb::dsl {

/// Every function reports the errors it finds, and returns null if it could not parse anything. The
/// cursor is then inside the statement, and the caller skips to the end of it.
class ValueParser {
 public:
  explicit ValueParser(TokenCursor& cursor) : cursor_(cursor) {}

  /// Parses `value` of the grammar: a sum, a ratio, a range, a text or a bare call.
  ExprPtr ParseValue();
  /// Parses a whole `condition` of the grammar.
  ConditionPtr ParseCondition();
  /// True if `name :` is `ahead` tokens away: an argument, unless a ratio begins with a name.
  bool AtLabel(std::size_t ahead = 0) const;
  /// Reports and takes an `as name` that has nothing to name.
  void ReportMisplacedAs();

 private:
  ExprPtr ParseSum();
  ExprPtr ParseProduct();
  /// True at a unit that can follow the value before it: `ms` after `10` or `)`.
  bool AtUnit() const;
  /// `value` with the unit at the cursor.
  ExprPtr FinishQuantity(ExprPtr value);
  bool TakePower(std::string& unit);
  ExprPtr ParsePower();
  ExprPtr ParseUnary();
  ExprPtr ParsePrimary();
  ExprPtr ParseBracketed();
  ExprPtr ParseCall(const Token& name);
  bool ParseAxisName(Expr& call);
  bool ParseLimits(Expr& call);
  bool ParseArgument(Expr& call);
  bool ParseLabelled(Argument& argument);
  /// True at the `until:` of a `find( )`, which a condition follows, or of a `sweep( )` that was
  /// meant as one.
  bool AtUntil(const Expr& call) const;
  bool ParseUntil(Expr& call);
  /// Parses `ring radius: 20`: a call with one argument, without brackets.
  ExprPtr ParseBareCall();
  ExprPtr ParseText();
  ExprPtr ParsePath();
  /// Parses the rest of a ratio or a range after its first sum.
  ExprPtr FinishValue(ExprPtr first);
  ExprPtr FinishRatio(std::vector<ExprPtr> parts);
  ExprPtr FinishRange(ExprPtr first);
  enum class RangeWord { kTaken, kNone, kFailed };
  RangeWord TakeRangeWord(Expr& range);
  RangeWord ParseRangeNumber(Expr& range, const Token& word, std::string_view meant);

  ConditionPtr ParseAnd();
  /// Operands that an operator separates, from the left.
  ConditionPtr ParseLogic(ConditionKind kind, bool (ValueParser::*at_operator)() const,
                          ConditionPtr (ValueParser::*parse)());
  ConditionPtr ParseOperand();
  ConditionPtr ParseNot();
  ConditionPtr ParseBracketedCondition();
  ConditionPtr ParseComparison();
  ConditionPtr ParseIn(ConditionPtr condition);
  bool ParseInList(const Token& word, std::vector<ExprPtr>& values);
  /// True at `in (`.
  bool AtIn(std::size_t ahead) const {
    return cursor_.AtWord("in", ahead) && cursor_.Peek(ahead + 1).kind == TokenKind::kLeftParen;
  }
  bool AtComparison() const;
  /// True where a comparison, or a side of it, cannot continue.
  bool AtComparisonEnd() const;
  void ReportMissingComparison();
  bool AtAnd() const { return cursor_.At(TokenKind::kAnd) || cursor_.AtWord("and"); }
  bool AtOr() const { return cursor_.At(TokenKind::kOr) || cursor_.AtWord("or"); }
  bool AtNot() const { return cursor_.At(TokenKind::kNot) || cursor_.AtWord("not"); }
  /// True if the bracket at the cursor groups conditions, not numbers.
  bool BracketHoldsCondition() const;

  /// Parses a list after its opening bracket. `parse_one` returns false if it could not go on; the
  /// rest of the list is still read. False if the end of the list was not found.
  template <typename ParseOne>
  bool ParseList(const Token& open, ParseOne parse_one);
  /// Takes the closing bracket of `open`; false, with a report, if it is missing.
  bool Close(const Token& open, std::string_view expected);
  bool AtClose() const {
    return cursor_.At(TokenKind::kRightParen) || cursor_.At(TokenKind::kRightBracket);
  }
  /// Skips to the next `,` or closing bracket of this list, or to the end of the statement.
  void SkipElement();
  Token TakeOpen();
  std::string InsteadOfSquareBrackets(const Token& open, std::size_t index) const;

  ExprPtr Make(ExprKind kind, std::uint32_t begin) const;
  /// Sets span and height from the parts; null, with a report, if it nests too deeply.
  ExprPtr Finish(ExprPtr expr, const text::Span& fault);
  ExprPtr MakeBinary(const Token& op, ExprPtr left, ExprPtr right);
  ConditionPtr MakeLogic(ConditionKind kind, const text::Span& fault, ConditionPtr left,
                         ConditionPtr right);
  void ReportMissingValue();

  TokenCursor& cursor_;
  bool is_log_alone_ = false;  // whether `log` may follow a range without a count
  bool bracketed_ = false;     // whether the condition parsed last was in brackets
};

}  // namespace cdb::dsl
