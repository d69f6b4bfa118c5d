#include "compiler/evaluate/operators.h"

#include <fmt/format.h>

#include "compiler/evaluate/evaluate.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using Eigen::Vector3d;

Term OfNumbers(char op, const Number& a, const Number& b) {
  switch (op) {
    case '+':
      return Term{a + b};
    case '-':
      return Term{a - b};
    case '*':
      return Term{a * b};
    case '/':
      return Term{a / b};
    default:
      return Term{Power(a, b)};
  }
}

/// nullopt where the operator does not go between the two kinds.
std::optional<Term> Apply(char op, const Term& left, const Term& right) {
  if (left.number() && right.number()) return OfNumbers(op, *left.number(), *right.number());
  if (left.vector() && right.vector() && (op == '+' || op == '-')) {
    const double sign = op == '+' ? 1 : -1;
    return Term{Vector3d(*left.vector() + sign * *right.vector())};
  }
  if (left.number() && right.vector() && op == '*')
    return Term{Vector3d(left.number()->AsReal() * *right.vector())};
  if (left.vector() && right.number() && op == '*')
    return Term{Vector3d(*left.vector() * right.number()->AsReal())};
  if (left.vector() && right.number() && op == '/')
    return Term{Vector3d(*left.vector() / right.number()->AsReal())};
  return std::nullopt;
}

bool DividesByZero(char op, const Term& left, const Term& right) {
  return op == '/' && (left.number() || left.vector()) && right.number() &&
         right.number()->AsReal() == 0;
}

std::nullopt_t ReportOperands(const Expr& expr, const Term& left, const Term& right,
                              const scenario::Scope& scope, Evaluator& evaluator) {
  for (const int side : {0, 1}) {
    const Term& term = side == 0 ? left : right;
    const dsl::Span& span = expr.items[static_cast<std::size_t>(side)]->span;
    if (const schema::Word* word = term.word()) {
      const std::string_view near = evaluator.names().NearestLet(word->text, scope);
      return evaluator.Error(scenario::kUnknownName, span,
                             fmt::format("no let is called '{}'", word->text),
                             near.empty() ? "" : fmt::format("did you mean '{}'?", near));
    }
    if (!term.number() && !term.vector())
      return evaluator.Error(scenario::kWrongKind, span,
                             fmt::format("cannot calculate with {}", KindName(term)));
  }
  return evaluator.Error(
      scenario::kWrongKind, expr.span,
      fmt::format("'{}' does not go between {} and {}", expr.op, KindName(left), KindName(right)));
}

}  // namespace

std::optional<Term> EvaluateNegation(const Expr& expr, const scenario::Scope& scope,
                                     Evaluator& evaluator) {
  const auto operand = evaluator.Evaluate(*expr.items[0], scope);
  if (!operand) return std::nullopt;
  if (operand->number()) return Term{-*operand->number()};
  if (operand->vector()) return Term{Vector3d(-*operand->vector())};
  return evaluator.Error(scenario::kWrongKind, expr.span,
                         fmt::format("{} cannot be negated", KindName(*operand)));
}

std::optional<Term> EvaluateBinary(const Expr& expr, const scenario::Scope& scope,
                                   Evaluator& evaluator) {
  const auto left = evaluator.Evaluate(*expr.items[0], scope);
  const auto right = evaluator.Evaluate(*expr.items[1], scope);
  if (!left || !right) return std::nullopt;
  if (DividesByZero(expr.op, *left, *right))
    return evaluator.Error(scenario::kNotFinite, expr.items[1]->span, "division by zero");
  if (auto result = Apply(expr.op, *left, *right)) return result;
  return ReportOperands(expr, *left, *right, scope, evaluator);
}

}  // namespace cdb::evaluate
