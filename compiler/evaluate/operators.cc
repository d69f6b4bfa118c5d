#include "compiler/evaluate/operators.h"

#include <fmt/format.h>

#include <string>

#include "compiler/evaluate/drawn_settings.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/names/kind_name.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/functions.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using Eigen::Vector3d;
using schema::Value;

/// Nullopt if the operator is not defined for the two kinds.
std::optional<Value> Apply(char op, const Value& left, const Value& right) {
  if (AsNumber(left) && AsNumber(right))
    return schema::Calculate(op, *AsNumber(left), *AsNumber(right));
  if (AsVector(left) && AsVector(right) && (op == '+' || op == '-')) {
    const double sign = op == '+' ? 1 : -1;
    return Value(Vector3d(*AsVector(left) + sign * *AsVector(right)));
  }
  if (AsNumber(left) && AsVector(right) && op == '*')
    return Value(Vector3d(AsNumber(left)->AsReal() * *AsVector(right)));
  if (AsVector(left) && AsNumber(right) && op == '*')
    return Value(Vector3d(*AsVector(left) * AsNumber(right)->AsReal()));
  if (AsVector(left) && AsNumber(right) && op == '/')
    return Value(Vector3d(*AsVector(left) / AsNumber(right)->AsReal()));
  return std::nullopt;
}

bool IsNumeric(const Value& value) { return AsNumber(value) || AsFormula(value); }

bool DividesByZero(char op, const Value& left, const Value& right) {
  return op == '/' && (IsNumeric(left) || AsVector(left)) && AsNumber(right) &&
         AsNumber(right)->AsReal() == 0;
}

std::nullopt_t ReportOperands(const Expr& expr, const Value& left, const Value& right,
                              const scenario::Scope& scope, Evaluator& evaluator) {
  for (const int side : {0, 1}) {
    const Value& value = side == 0 ? left : right;
    const text::Span& span = expr.items[static_cast<std::size_t>(side)]->span;
    if (const schema::Word* word = AsWord(value)) {
      const std::string_view near = evaluator.names().NearestLet(word->text, scope);
      return evaluator.Error(scenario::kUnknownName, span,
                             fmt::format("no let is called '{}'", word->text),
                             near.empty() ? "" : fmt::format("did you mean '{}'?", near));
    }
    if (!IsNumeric(value) && !AsVector(value))
      return evaluator.Error(
          scenario::kWrongKind, span,
          fmt::format("{} cannot be used in arithmetic", names::KindName(value)));
  }
  return evaluator.Error(scenario::kWrongKind, expr.span,
                         fmt::format("'{}' cannot be applied to {} and {}", expr.op,
                                     names::KindName(left), names::KindName(right)));
}

}  // namespace

std::optional<Value> EvaluateNegation(const Expr& expr, const scenario::Scope& scope,
                                      Evaluator& evaluator) {
  const auto operand = evaluator.Evaluate(*expr.items[0], scope);
  if (!operand) return std::nullopt;
  if (AsNumber(*operand)) return -*AsNumber(*operand);
  if (AsVector(*operand)) return Value(Vector3d(-*AsVector(*operand)));
  if (AsFormula(*operand)) return MakeFormula("-", {*operand}, expr.span, evaluator);
  return evaluator.Error(scenario::kWrongKind, expr.span,
                         fmt::format("{} cannot be negated", names::KindName(*operand)));
}

std::optional<Value> EvaluateBinary(const Expr& expr, const scenario::Scope& scope,
                                    Evaluator& evaluator) {
  const auto left = evaluator.Evaluate(*expr.items[0], scope);
  const auto right = evaluator.Evaluate(*expr.items[1], scope);
  if (!left || !right) return std::nullopt;
  if (DividesByZero(expr.op, *left, *right))
    return evaluator.Error(scenario::kNotFinite, expr.items[1]->span, "division by zero");
  if (auto result = Apply(expr.op, *left, *right)) return result;
  if (IsNumeric(*left) && IsNumeric(*right))
    return MakeFormula(std::string(1, expr.op), {*left, *right}, expr.span, evaluator);
  return ReportOperands(expr, *left, *right, scope, evaluator);
}

}  // namespace cdb::evaluate
