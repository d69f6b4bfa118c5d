#include "compiler/configure/conditions.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/evaluate/drawn_settings.h"
#include "compiler/evaluate/functions.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::configure {
namespace {

using dsl::Expr;
using dsl::ExprKind;
using schema::Number;
using schema::Value;

bool CompareNumbers(const std::string& op, const Number& left, const Number& right) {
  const auto order = Compare(left, right);
  if (op == "==") return order == 0;
  if (op == "!=") return order != 0;
  if (op == "<") return order < 0;
  if (op == "<=") return order <= 0;
  if (op == ">") return order > 0;
  return order >= 0;
}

bool AreEqual(const Value& left, const Value& right) {
  if (AsVector(left) && AsVector(right)) return *AsVector(left) == *AsVector(right);
  return AsNumber(left) == nullptr && AsNumber(right) == nullptr && LabelOf(left) == LabelOf(right);
}

}  // namespace

void Conditions::SetAxis(const std::string& name, Value value) {
  axis_values_.insert_or_assign(name, std::move(value));
}

void Conditions::SetAxisWords(const std::string& name, std::vector<std::string> words) {
  axis_words_.insert_or_assign(name, std::move(words));
}

bool Conditions::Hold(const dsl::Condition& condition, const scenario::Scope& scope) {
  using enum dsl::ConditionKind;
  switch (condition.kind) {
    case kNot:
      return !Hold(*condition.items[0], scope);
    case kAnd:
    case kOr: {
      // Both sides are always evaluated, so that every error is found.
      const bool left = Hold(*condition.items[0], scope);
      const bool right = Hold(*condition.items[1], scope);
      return condition.kind == kAnd ? left && right : left || right;
    }
    case kIn: {
      bool is_one = false;
      for (const auto& value : condition.values)
        is_one = Compare(*condition.left, "==", *value, condition.span, scope) || is_one;
      return is_one;
    }
    case kCompare:
      break;
  }
  return Compare(*condition.left, condition.op, *condition.right, condition.span, scope);
}

void Conditions::CheckCalls(const dsl::Condition& condition) {
  for (const auto& item : condition.items) CheckCalls(*item);
  if (condition.left) RefuseCall(*condition.left);
  if (condition.right) RefuseCall(*condition.right);
  for (const auto& value : condition.values) RefuseCall(*value);
}

/// A call in a condition does not have a single value: true, with a report.
bool Conditions::RefuseCall(const Expr& expr) {
  if (expr.kind == ExprKind::kCall && expr.text == "sweep") {
    evaluator_.Error(scenario::kMisplacedSweep, expr.span, "a condition cannot contain a sweep",
                     "sweep a setting or a let, and compare its name");
    return true;
  }
  if (expr.kind == ExprKind::kCall && schema::FindDistribution(expr.text)) {
    evaluator_.Error(
        scenario::kBadComparison, expr.span,
        fmt::format("{}() is drawn for each object and has no single value", expr.text),
        "conditions can compare axes, lets and parameters");
    return true;
  }
  return std::ranges::any_of(expr.items, [this](const auto& item) { return RefuseCall(*item); }) ||
         std::ranges::any_of(expr.arguments,
                             [this](const auto& item) { return RefuseCall(*item.value); });
}

bool Conditions::Compare(const Expr& left_expr, const std::string& op, const Expr& right_expr,
                         const text::Span& span, const scenario::Scope& scope) {
  if (RefuseCall(left_expr) || RefuseCall(right_expr)) return false;
  for (const bool swap : {false, true}) {
    const Expr& word = swap ? left_expr : right_expr;
    const Expr& other = swap ? right_expr : left_expr;
    if (IsLiteralWord(word, scope) && !CheckWord(word, other, scope)) return false;
  }
  const auto left = Comparand(left_expr, right_expr, scope);
  const auto right = Comparand(right_expr, left_expr, scope);
  if (!left || !right) return false;
  if (AsNumber(*left) && AsNumber(*right))
    return CompareNumbers(op, *AsNumber(*left), *AsNumber(*right));
  if (op != "==" && op != "!=") {
    evaluator_.Error(scenario::kBadComparison, span, fmt::format("'{}' compares only numbers", op),
                     "words are compared with == and !=");
    return false;
  }
  return (op == "==") == AreEqual(*left, *right);
}

std::optional<Value> Conditions::Comparand(const Expr& expr, const Expr& other,
                                           const scenario::Scope& scope) {
  if (expr.kind == ExprKind::kPath) {
    // Beside `omit`, `sleeping` is a component and not the switch of that name.
    const auto words = WordsOf(other, scope);
    if (std::ranges::find(words, expr.text) != words.end() &&
        !evaluator_.names().Resolve(expr.text, scope).let)
      return schema::Word{expr.text};
    const auto axis = axis_values_.find(expr.text);
    if (axis != axis_values_.end()) return axis->second;
  }
  auto value = evaluator_.Evaluate(expr, scope);
  if (!value || !AsFormula(*value)) return value;
  evaluate::RefuseFormula(*AsFormula(*value), evaluator_.diagnostics());
  return std::nullopt;
}

std::string Conditions::Nearest(std::string_view word, std::vector<std::string_view> words,
                                const scenario::Scope& scope) const {
  if (!words.empty()) return std::string(dsl::DidYouMean(word, words));
  for (const auto& [name, value] : axis_values_) words.push_back(name);
  if (const auto axis = dsl::DidYouMean(word, words); !axis.empty()) return std::string(axis);
  if (const auto let = evaluator_.names().NearestLet(std::string(word), scope); !let.empty())
    return std::string(let);
  words.clear();
  for (const schema::Parameter& parameter : schema::Schema()) words.push_back(parameter.name);
  return std::string(dsl::DidYouMean(word, words));
}

bool Conditions::CheckWord(const Expr& word, const Expr& other, const scenario::Scope& scope) {
  const std::vector<std::string_view> words = WordsOf(other, scope);
  if (other.kind == ExprKind::kPath && !axis_values_.contains(other.text) &&
      evaluator_.names().Resolve(other.text, scope).let)
    return true;
  if (std::ranges::find(words, word.text) != words.end()) return true;
  // It may be an axis with an error.
  if (words.empty() && evaluator_.layers().has_unread) return false;
  const std::string near = Nearest(word.text, words, scope);
  std::string help;
  if (!near.empty()) {
    help = fmt::format("did you mean '{}'?", near);
  } else if (!words.empty()) {
    help = fmt::format("it is one of {}", fmt::join(words, ", "));
  }
  evaluator_.Error(scenario::kUnknownName, word.span,
                   words.empty()
                       ? fmt::format("no axis, let or parameter is called '{}'", word.text)
                       : fmt::format("'{}' is never '{}'", other.text, word.text),
                   std::move(help));
  return false;
}

bool Conditions::IsLiteralWord(const Expr& expr, const scenario::Scope& scope) const {
  return expr.kind == ExprKind::kPath && expr.text != evaluate::kPiName &&
         !axis_values_.contains(expr.text) && evaluator_.names().Resolve(expr.text, scope).IsWord();
}

std::vector<std::string_view> Conditions::WordsOf(const Expr& expr,
                                                  const scenario::Scope& scope) const {
  if (expr.kind != ExprKind::kPath) return {};
  if (const auto axis = axis_words_.find(expr.text); axis != axis_words_.end())
    return {axis->second.begin(), axis->second.end()};
  if (axis_values_.contains(expr.text)) return {};
  const names::Referent referent = evaluator_.names().Resolve(expr.text, scope);
  if (!referent.parameter) return {};
  const schema::Parameter& parameter = *referent.parameter->second;
  std::vector<std::string_view> words = parameter.AllWords(evaluator_.scenario().plugins());
  for (const std::string_view call : parameter.AllCalls()) words.push_back(call);
  return words;
}

}  // namespace cdb::configure
