#include "compiler/evaluate/drawn_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "compiler/evaluate/evaluate.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/formula.h"

namespace cdb::evaluate {
namespace {

using schema::Formula;
using schema::Value;

std::string_view TextOf(const text::Span& span) {
  return span.source->text().substr(span.begin, span.end - span.begin);
}

/// The names of settings in a formula, also in one that is the argument of same( ) or density( ).
std::vector<const Formula*> NamesIn(const Value& value) {
  const schema::Call* call = AsCall(value);
  if (call == nullptr) return schema::SettingsIn(value);
  std::vector<const Formula*> names;
  for (const Value& argument : call->arguments)
    for (const Formula* name : schema::SettingsIn(argument)) names.push_back(name);
  return names;
}

}  // namespace

bool IsDrawnForEachObject(const Value& value) {
  const schema::Call* call = AsCall(value);
  return AsDistribution(value) || AsFormula(value) ||
         (call != nullptr && (call->name == "same" || call->name == "density"));
}

std::optional<Value> NamedSetting(const dsl::Expr& path, const scenario::ParameterKey& key,
                                  const Value& value, Evaluator& evaluator) {
  const auto refuse = [&](std::string message, std::string help = {}) {
    return evaluator.Error(scenario::kWrongKind, path.span, std::move(message), std::move(help));
  };
  if (key.first.empty() || key.second->type != schema::ParameterType::kReal)
    return refuse(fmt::format("'{}' is drawn for each object and has no single value", path.text));
  const schema::Distribution* drawn = AsDistribution(value);
  if (drawn != nullptr && key.second == schema::GroupParameter("size").get())
    return refuse(
        fmt::format("'{}' draws each side separately, so that an object has no single size",
                    path.text),
        fmt::format("write size same({})", LabelOf(value)));
  if (drawn != nullptr)
    for (const Value& choice : drawn->arguments)
      if (AsWord(choice))
        return refuse(fmt::format("'{}' can be drawn as {}, which is not a number", path.text,
                                  LabelOf(choice)));
  Formula formula;
  formula.setting = key.second->name;
  formula.group = key.first;
  formula.written = path.span;
  return formula;
}

std::optional<Value> MakeFormula(std::string op, std::vector<Value> arguments,
                                 const text::Span& span, Evaluator& evaluator) {
  Formula formula;
  formula.op = std::move(op);
  // As in a plan, which does not distinguish integers and reals here.
  for (Value& argument : arguments)
    formula.arguments.push_back(AsNumber(argument) ? Value(AsNumber(argument)->AsReal())
                                                   : std::move(argument));
  Value value = std::move(formula);
  if (schema::FormulaParts(value) <= schema::kMostFormulaParts) return value;
  return evaluator.Error(
      scenario::kWrongKind, span,
      fmt::format("an expression of drawn values has at most {} numbers, names and operators",
                  schema::kMostFormulaParts));
}

void RefuseFormula(const Formula& formula, dsl::Diagnostics& diagnostics) {
  const Value value = formula;
  const Formula& name = *schema::SettingsIn(value).front();
  diagnostics.Report(
      scenario::kWrongKind, name.written,
      fmt::format("'{}' is drawn for each object and has no single value", TextOf(name.written)));
}

std::optional<Value> OfOwnGroup(Value value, const scenario::ParameterKey& key,
                                Evaluator& evaluator) {
  if (key.first.empty()) return value;  // any formula is an error in the world
  for (const Formula* name : NamesIn(value)) {
    if (name->group == key.first) continue;
    const schema::Parameter* parameter = schema::FindParameter(name->setting, true);
    // `size pebbles.size` is a same( ) like that of the other group, but with separate draws.
    if (AsFormula(value) && AsFormula(value)->op.empty())
      if (auto other = evaluator.EvaluateParameter({name->group, parameter});
          other && AsCall(*other))
        return other;
    return evaluator.Error(
        scenario::kWrongKind, name->written,
        fmt::format(
            "'{}' is drawn for each object of '{}', and has no single value for those of '{}'",
            TextOf(name->written), name->group, key.first),
        "an expression can name drawn settings of its own group only");
  }
  return value;
}

}  // namespace cdb::evaluate
