#include "compiler/evaluate/sweeps.h"

#include <fmt/format.h>

#include "compiler/evaluate/evaluate.h"
#include "compiler/evaluate/ranges.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using dsl::ExprKind;
using schema::Number;
using schema::Value;

/// Restores a value at the end of a scope.
template <typename T>
class Restore {
 public:
  Restore(T& target, T value) : target_(target), old_(target) { target_ = value; }
  ~Restore() { target_ = old_; }

 private:
  T& target_;
  T old_;
};

}  // namespace

const Sweep* Sweeps::Find(const Expr& call, const scenario::Scope& scope) {
  const auto known = sweeps_.find(&call);
  if (known != sweeps_.end()) return known->second ? &*known->second : nullptr;
  // It is empty until expanded: a sweep that refers to itself fails.
  std::optional<Sweep>& sweep = sweeps_[&call];
  sweep = Expand(call, scope);
  return sweep ? &*sweep : nullptr;
}

bool Sweeps::Choose(const Expr& call, std::size_t index) {
  std::size_t& chosen = chosen_[&call];
  if (chosen == index) return false;
  chosen = index;
  return true;
}

std::optional<Value> Sweeps::Evaluate(const Expr& call, const scenario::Scope& scope) {
  if (is_inside_)
    return evaluator_.Error(scenario::kMisplacedSweep, call.span, "a sweep cannot contain a sweep");
  const Sweep* sweep = Find(call, scope);
  if (sweep == nullptr) return std::nullopt;
  const Sweep::Item& item = sweep->items[chosen_[&call]];
  if (item.number) return Value(*item.number);
  const Restore guard(is_inside_, true);
  return evaluator_.Evaluate(*item.expr, scope);
}

const Expr& Sweeps::Origin(const Expr& expr, const scenario::Scope& scope) {
  if (expr.kind != ExprKind::kCall || expr.text != "sweep") return expr;
  const Sweep* sweep = Find(expr, scope);
  if (sweep == nullptr) return expr;
  const Expr* item = sweep->items[chosen_[&expr]].expr;
  return item != nullptr ? *item : expr;
}

std::optional<Sweep> Sweeps::Expand(const Expr& call, const scenario::Scope& scope) {
  Sweep sweep;
  const Restore guard(is_inside_, true);
  bool good = true;
  for (const dsl::Argument& argument : call.arguments) {
    if (argument.name) {
      evaluator_.Error(scenario::kBadArguments, argument.name->span,
                       fmt::format("sweep() has no argument '{}'", argument.name->text),
                       "sweep(1, 2, 5) or sweep(1 .. 5)");
      good = false;
    } else if (argument.weight) {
      evaluator_.Error(scenario::kBadArguments, argument.weight->span,
                       "sweep() does not take weights", "separate the values by commas");
      good = false;
    } else {
      good = AddItems(*argument.value, scope, sweep.items) && good;
    }
  }
  if (good && sweep.items.size() > kMaxAxisValues) {
    evaluator_.Error(scenario::kTooManyRuns, call.span,
                     fmt::format("this sweep has {} values", sweep.items.size()),
                     fmt::format("an axis can have at most {}", kMaxAxisValues));
    good = false;
  }
  if (good && sweep.items.empty()) {
    evaluator_.Error(scenario::kBadArguments, call.span, "sweep() has no values",
                     "sweep(1, 2, 5) or sweep(1 .. 5)");
    good = false;
  }
  if (!good) return std::nullopt;
  return sweep;
}

bool Sweeps::AddItems(const Expr& expr, const scenario::Scope& scope,
                      std::vector<Sweep::Item>& items) {
  const Expr* range = expr.kind == ExprKind::kRange ? &expr : nullptr;
  scenario::Scope inner = scope;
  if (expr.kind == ExprKind::kPath) {
    // A let may contain a range.
    const names::Referent referent = evaluator_.names().Resolve(expr.text, scope);
    if (referent.let && referent.let->node->value->kind == ExprKind::kRange) {
      range = referent.let->node->value.get();
      inner = referent.let->scope;
    }
  }
  if (range != nullptr) {
    auto numbers = ExpandRange(*range, inner, evaluator_);
    if (!numbers) return false;
    const bool is_count =
        scope.parameter != nullptr && scope.parameter->type == schema::ParameterType::kCount;
    if (is_count && range->range == dsl::RangeKind::kCountLog) RoundBetweenEnds(*numbers);
    for (const Number& number : *numbers) items.push_back({nullptr, number});
    return true;
  }
  items.push_back({&expr, std::nullopt});
  // Reported here, since a value with an error might never be chosen.
  return evaluator_.Evaluate(expr, scope).has_value();
}

}  // namespace cdb::evaluate
