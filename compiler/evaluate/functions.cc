#include "compiler/evaluate/functions.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "compiler/evaluate/drawn_settings.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/names/kind_name.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/functions.h"

namespace cdb::evaluate {
namespace {

using schema::Function;
using schema::Number;
using schema::Value;

bool CheckForm(const dsl::Expr& call, const Function& function, Evaluator& evaluator) {
  for (const dsl::Argument& argument : call.arguments) {
    if (!argument.name && !argument.weight) continue;
    evaluator.Error(
        scenario::kBadArguments, argument.name ? argument.name->span : argument.weight->span,
        fmt::format("{}() takes only numbers", function.name), "separate them by commas");
    return false;
  }
  const std::size_t count = call.arguments.size();
  if (count >= 1 && count <= function.most_arguments) return true;
  evaluator.Error(
      scenario::kBadArguments, call.span,
      fmt::format("{}() takes {}, but there are {}", function.name,
                  function.most_arguments == 1 ? "one number" : "one number or more", count));
  return false;
}

}  // namespace

std::vector<std::string_view> FunctionNames() {
  std::vector<std::string_view> names;
  for (const Function& function : schema::Functions()) names.push_back(function.name);
  return names;
}

bool IsFunction(std::string_view name) { return schema::FindFunction(name) != nullptr; }

std::optional<Value> EvaluateFunction(const dsl::Expr& call, const scenario::Scope& scope,
                                      Evaluator& evaluator) {
  const Function& function = *schema::FindFunction(call.text);
  if (!CheckForm(call, function, evaluator)) return std::nullopt;
  std::vector<Number> numbers;
  std::vector<Value> operands;
  for (const dsl::Argument& argument : call.arguments) {
    const auto value = evaluator.Evaluate(*argument.value, scope);
    if (!value) return std::nullopt;
    if (!AsNumber(*value) && !AsFormula(*value))
      return evaluator.Error(
          scenario::kWrongKind, argument.value->span,
          fmt::format("{}() takes numbers, but this is {}", call.text, names::KindName(*value)));
    operands.push_back(*value);
    if (AsNumber(*value)) numbers.push_back(*AsNumber(*value));
  }
  if (numbers.size() < operands.size())
    return MakeFormula(call.text, std::move(operands), call.span, evaluator);
  if (!function.domain.Contains(numbers[0].AsReal()))
    return evaluator.Error(
        scenario::kNotFinite, call.span,
        fmt::format("{}({}) is not a real number", call.text, numbers[0].Text()),
        fmt::format("{}() takes a number {}", call.text, function.domain.Text()));
  const Number result = function.apply(numbers);
  if (std::isfinite(result.AsReal())) return result;
  return evaluator.Error(
      scenario::kNotFinite, call.span,
      fmt::format("{}({}) does not fit into a 64-bit real", call.text, numbers[0].Text()));
}

}  // namespace cdb::evaluate
