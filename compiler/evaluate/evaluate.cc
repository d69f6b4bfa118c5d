#include "compiler/evaluate/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "compiler/evaluate/calls.h"
#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/dimensions.h"
#include "compiler/names/named_files.h"
#include "compiler/names/names.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/formula.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using dsl::ExprKind;
using Eigen::Vector3d;
using schema::Number;
using schema::Value;

constexpr std::size_t kMaxChain = 500;

std::optional<Value> EvaluateLiteral(const Expr& expr, Evaluator& evaluator) {
  const auto number = Number::FromLiteral(expr.text);
  if (number) return *number;
  return evaluator.Error(scenario::kNotFinite, expr.span,
                         fmt::format("'{}' does not fit into 64 bits", expr.text));
}

std::optional<Eigen::Vector3d> EvaluateTriple(const Expr& expr, const scenario::Scope& scope,
                                              const char* what, Evaluator& evaluator) {
  Eigen::Vector3d triple;
  for (int i = 0; i < 3; ++i) {
    const auto number =
        evaluator.EvaluateNumber(*expr.items[static_cast<std::size_t>(i)], scope, what);
    if (!number) return std::nullopt;
    triple[i] = number->AsReal();
  }
  return triple;
}

std::optional<Value> EvaluateVector(const Expr& expr, const scenario::Scope& scope,
                                    Evaluator& evaluator) {
  if (scope.parameter != nullptr && scope.parameter->type == schema::ParameterType::kWords)
    return evaluator.Error(
        scenario::kWrongKind, expr.span,
        fmt::format("'{}' takes words without parentheses", scope.parameter->name),
        "use cases { } for an axis whose values are lists");
  if (expr.items.size() != 3) return std::nullopt;  // reported by the parser
  const auto vector = EvaluateTriple(expr, scope, "a vector's components", evaluator);
  return vector ? std::optional<Value>(*vector) : std::nullopt;
}

std::optional<Value> EvaluateRatio(const Expr& expr, const scenario::Scope& scope,
                                   Evaluator& evaluator) {
  const auto parts = EvaluateTriple(expr, scope, "a ratio's parts", evaluator);
  return parts ? std::optional<Value>(schema::Ratio{*parts}) : std::nullopt;
}

/// The value of a list parameter. Several words are one value: `gravity, walls`.
std::optional<Value> EvaluateList(const dsl::Setting& setting, const scenario::Scope& scope,
                                  Evaluator& evaluator) {
  if (setting.values.size() == 1) return evaluator.Evaluate(*setting.values[0], scope);
  schema::WordList words;
  for (const auto& value : setting.values) {
    const auto word = evaluator.Evaluate(*value, scope);
    if (!word) return std::nullopt;
    words.push_back(LabelOf(*word));
  }
  std::ranges::sort(words);
  return schema::Word{schema::ToText(std::move(words))};
}

bool IsFinite(const Value& value) {
  if (AsNumber(value)) return std::isfinite(AsNumber(value)->AsReal());
  return AsVector(value) == nullptr || AsVector(value)->allFinite();
}

}  // namespace

Evaluator::Evaluator(const scenario::Scenario& scenario, const scenario::Layers& layers,
                     dsl::Diagnostics& diagnostics)
    : scenario_(scenario),
      layers_(layers),
      diagnostics_(diagnostics),
      names_(scenario, layers),
      sweeps_(*this) {}

std::nullopt_t Evaluator::Error(const dsl::DiagnosticKind& kind, const text::Span& span,
                                std::string message, std::string help) {
  diagnostics_.Report(kind, span, std::move(message), std::move(help));
  return std::nullopt;
}

void Evaluator::Choose(const Expr& call, std::size_t index) {
  bool is_changed = sweeps_.Choose(call, index);
  if (call.zip)
    for (const Expr* sweep : call.zip->sweeps)
      is_changed = sweeps_.Choose(*sweep, index) || is_changed;
  if (is_changed) let_values_.clear();
}

std::optional<Value> Evaluator::Evaluate(const Expr& expr, const scenario::Scope& scope) {
  // The numbers in names and calls are checked where they are written.
  const bool is_checked = expr.kind == ExprKind::kPath || expr.kind == ExprKind::kCall;
  auto value = EvaluateUnchecked(expr, scope);
  if (!value || is_checked || IsFinite(*value)) return value;
  return Error(scenario::kNotFinite, expr.span, "this is not a finite number");
}

std::optional<Value> Evaluator::EvaluateUnchecked(const Expr& expr, const scenario::Scope& scope) {
  switch (expr.kind) {
    case ExprKind::kNumber:
      return EvaluateLiteral(expr, *this);
    case ExprKind::kText:
      return schema::Text{expr.text, expr.span};
    case ExprKind::kPath:
      return EvaluatePath(expr, scope);
    case ExprKind::kVector:
      return EvaluateVector(expr, scope, *this);
    case ExprKind::kRatio:
      return EvaluateRatio(expr, scope, *this);
    case ExprKind::kCall:
      return EvaluateCall(expr, scope, *this);
    case ExprKind::kNegate:
      return EvaluateNegation(expr, scope, *this);
    case ExprKind::kBinary:
      return EvaluateBinary(expr, scope, *this);
    case ExprKind::kQuantity:
      return EvaluateQuantity(expr, scope, *this);
    case ExprKind::kError:
      return std::nullopt;
    case ExprKind::kRange:
      return Error(scenario::kMisplacedRange, expr.span, "a range is not a value",
                   "sweep(…) around it makes one run for each of its values");
  }
  return std::nullopt;
}

std::optional<Number> Evaluator::EvaluateNumber(const Expr& expr, const scenario::Scope& scope,
                                                const char* what) {
  const auto value = Evaluate(expr, scope);
  if (!value) return std::nullopt;
  if (AsFormula(*value)) {
    RefuseFormula(*AsFormula(*value), diagnostics_);
    return std::nullopt;
  }
  if (!AsNumber(*value))
    return Error(scenario::kWrongKind, expr.span,
                 fmt::format("{} are numbers, but this is {}", what, names::KindName(*value)),
                 AsDistribution(*value)
                     ? "put the vectors into the distribution: uniform((0, 0, 0), (1, 2, 3))"
                     : "");
  return *AsNumber(*value);
}

bool Evaluator::IsWordHere(std::string_view word, const scenario::Scope& scope) const {
  if (word == "on" || word == "off" || word == "true" || word == "false") return true;
  return scope.parameter == nullptr || scope.parameter->HasWord(word, scenario_.plugins()) ||
         scope.parameter->TakesCall(word);
}

std::optional<Value> Evaluator::EvaluatePath(const Expr& expr, const scenario::Scope& scope) {
  const names::Referent referent = names_.Resolve(expr.text, scope);
  if (referent.IsWord()) {
    // It may be the name of a let with a syntax error.
    if (layers_.is_incomplete && !IsWordHere(expr.text, scope)) return std::nullopt;
    if (scope.parameter != nullptr && scope.parameter->is_formula &&
        scope.parameter->HasWord(expr.text))
      return Variable(expr);
    if (expr.text == kPiName) return Number(kPi);
    if (expr.text.find('.') != std::string::npos) {
      const bool is_text =
          scope.parameter != nullptr && scope.parameter->type == schema::ParameterType::kText;
      return Error(scenario::kUnknownName, expr.span, fmt::format("'{}' is not defined", expr.text),
                   is_text ? fmt::format("write \"{}\"", expr.text) : "");
    }
    return schema::Word{expr.text};
  }
  if (referent.is_object_count) return CountObjects();
  if (referent.measure) return EvaluateMeasure(expr, *referent.measure);
  const Node node = referent.let ? Node{referent.let->node}
                                 : Node{referent.parameter->second, referent.parameter->first};
  if (!CheckCircle(node, expr)) return std::nullopt;
  auto value =
      referent.let ? EvaluateLet(*referent.let) : EvaluateNamedParameter(expr, *referent.parameter);
  // Of the values in a formula of places, none is one of each object.
  if (value && AsFormula(*value) && scope.parameter != nullptr && scope.parameter->is_formula) {
    RefuseFormula(*AsFormula(*value), diagnostics_);
    return std::nullopt;
  }
  return value;
}

bool Evaluator::CheckCircle(const Node& node, const Expr& expr) {
  const auto begin = std::ranges::find(active_, node, &Active::node);
  if (begin != active_.end()) {
    // The report names the same member, wherever the cycle was entered.
    const auto first = std::min_element(begin, active_.end(), [](const Active& a, const Active& b) {
      return a.name.span.begin < b.name.span.begin;
    });
    std::vector<std::string> circle;
    for (auto at = first; at != active_.end(); ++at) circle.push_back(at->name.text);
    for (auto at = begin; at != first; ++at) circle.push_back(at->name.text);
    circle.push_back(first->name.text);
    Error(scenario::kCircular, first->name.span,
          fmt::format("'{}' refers to itself", first->name.text),
          fmt::format("{}", fmt::join(circle, " -> ")));
    return false;
  }
  if (active_.size() < kMaxChain) return true;
  // The rest of the chain would be too long as well.
  if (!std::exchange(is_chain_reported_, true))
    Error(scenario::kCircular, expr.span,
          fmt::format("'{}' refers to too many lets in turn", expr.text),
          fmt::format("lets can be nested {} deep", kMaxChain));
  return false;
}

std::optional<Value> Evaluator::EvaluateLet(const scenario::Placed<dsl::Let>& let) {
  const auto known = let_values_.find(let.node);
  if (known != let_values_.end()) return known->second;
  active_.push_back({{let.node}, let.node->name});
  auto value = Evaluate(*let.node->value, let.scope);
  active_.pop_back();
  let_values_[let.node] = value;
  return value;
}

std::optional<Value> Evaluator::EvaluateNamedParameter(const Expr& expr,
                                                       const scenario::ParameterKey& key) {
  const auto set = layers_.settings.find(key);
  const dsl::Name written{expr.text, expr.span};
  active_.push_back(
      {{key.second, key.first}, set != layers_.settings.end() ? set->second.node->path : written});
  auto value = EvaluateParameter(key);
  // A mass from a density also depends on the size.
  if (value && AsCall(*value) && AsCall(*value)->name == "density")
    if (!EvaluateSizeOf(key.first)) value = std::nullopt;
  active_.pop_back();
  if (!value || !IsDrawnForEachObject(*value)) return value;
  return NamedSetting(expr, key, *value, *this);
}

std::optional<Value> Evaluator::EvaluateMeasure(const Expr& expr,
                                                const names::BoxMeasure& measure) {
  std::vector<Value> values;
  for (const schema::GroupParameter parameter : names::BoxMeasure::kOf) {
    const scenario::ParameterKey key{measure.group, parameter.get()};
    if (!CheckCircle({key.second, key.first}, expr)) return std::nullopt;
    const auto set = layers_.settings.find(key);
    active_.push_back(
        {{key.second, key.first},
         set != layers_.settings.end() ? set->second.node->path : dsl::Name{expr.text, expr.span}});
    auto value = EvaluateParameter(key);
    active_.pop_back();
    if (!value) return std::nullopt;
    if (IsDrawnForEachObject(*value) || AsDistribution(*value))
      return Error(scenario::kWrongKind, expr.span,
                   fmt::format("'{}' is not one value: the {} of `{}` is drawn for each object",
                               expr.text, key.second->name, measure.group));
    values.push_back(*std::move(value));
  }
  analysis::ModelFault why;
  const auto model = scenario_.ModelAt(values[0], why);
  if (!model)
    return Error(scenario::kOutOfDomain, expr.span,
                 fmt::format("'{}' is unknown: {}", expr.text,
                             why.cause.empty() ? "models are not read here" : why.cause),
                 why.remedy);
  const Number* size = AsNumber(values[1]);
  const auto* aspect = std::get_if<schema::Ratio>(&values[2]);
  const Vector3d sides = model->SidesOf(size != nullptr ? size->AsReal() : 0,
                                        aspect != nullptr ? aspect->parts : Vector3d::Ones());
  using Kind = names::BoxMeasure::Kind;
  const double half = measure.kind == Kind::kLower ? -0.5 : 0.5;
  const Vector3d box =
      measure.kind == Kind::kExtent
          ? sides
          : Vector3d((Vector3d::Constant(half) - model->placed).cwiseProduct(sides));
  if (measure.axis) return Number(box[*measure.axis]);
  return box;
}

bool Evaluator::EvaluateSizeOf(const std::string& group) {
  const schema::Parameter* size = schema::GroupParameter("size").get();
  const auto set = layers_.settings.find({group, size});
  if (set == layers_.settings.end()) return true;
  // A cycle through here is found further in.
  if (std::ranges::find(active_, Node{size, group}, &Active::node) != active_.end()) return true;
  active_.push_back({{size, group}, set->second.node->path});
  const bool good = EvaluateParameter({group, size}).has_value();
  active_.pop_back();
  return good;
}

std::optional<Value> Evaluator::EvaluateParameter(const scenario::ParameterKey& key) {
  const auto set = layers_.settings.find(key);
  if (key.second->type == schema::ParameterType::kWords)
    return set != layers_.settings.end()
               ? EvaluateList(*set->second.node, set->second.scope, *this)
               : EvaluateList(names::DefaultSetting(*key.second), {}, *this);
  if (set != layers_.settings.end() && set->second.node->values.size() == 1)
    return Evaluate(*set->second.node->values[0], set->second.scope);
  if (set == layers_.settings.end() && key.second == schema::GroupParameter("quantity").get())
    if (auto count = CountPlaces(key.first)) return count;
  return Evaluate(*names::DefaultSetting(*key.second).values[0], {});
}

std::string_view UnitOf(const scenario::ParameterKey& key, Evaluator& evaluator) {
  if (key.second->slider_unit.empty()) return key.second->unit;
  const auto type =
      evaluator.EvaluateParameter({key.first, schema::GroupParameter("joints.type").get()});
  const schema::Word* word = type ? schema::AsWord(*type) : nullptr;
  return word != nullptr && word->text == "slider" ? key.second->slider_unit : key.second->unit;
}

bool Evaluator::ListsPlaces(const Expr& expr, const scenario::Scope& scope) {
  const Expr* at = &expr;
  scenario::Scope inner = scope;
  // A let may refer to itself, which is reported when it is evaluated.
  for (std::size_t i = 0; i < kMaxChain; ++i) {
    const Expr& chosen = sweeps_.Origin(*at, inner);
    if (chosen.kind == ExprKind::kCall)
      return chosen.text == "at" || chosen.text == schema::kPosesCall ||
             chosen.text == schema::kPathCall || chosen.text == schema::kRelativeCall;
    if (chosen.kind != ExprKind::kPath) return false;
    const names::Referent referent = names_.Resolve(chosen.text, inner);
    if (!referent.let) return false;
    at = referent.let->node->value.get();
    inner = referent.let->scope;
  }
  return false;
}

std::optional<Value> Evaluator::CountPlaces(const std::string& group) {
  const auto set = layers_.settings.find({group, schema::GroupParameter("location").get()});
  if (set == layers_.settings.end() || set->second.node->values.size() != 1) return std::nullopt;
  const dsl::Setting& setting = *set->second.node;
  // Other layouts may use the quantity themselves: ring(radius: quantity / 4).
  if (!ListsPlaces(*setting.values[0], set->second.scope)) return std::nullopt;
  if (!CheckCircle({&setting}, *setting.values[0])) return std::nullopt;
  active_.push_back({{&setting}, setting.path});
  const auto layout = Evaluate(*setting.values[0], set->second.scope);
  const schema::Call* call = layout ? AsCall(*layout) : nullptr;
  std::optional<Value> others;
  if (call != nullptr && call->name == schema::kRelativeCall) {
    const std::string& other = std::get<schema::Word>(ArgumentOf(*call, "group")).text;
    if (std::ranges::find(layers_.groups, other) != layers_.groups.end())
      others = EvaluateParameter({other, schema::GroupParameter("quantity").get()});
  }
  active_.pop_back();
  if (others) return others;
  analysis::PoseFault why;
  if (call != nullptr && (call->name == schema::kPosesCall || call->name == schema::kPathCall))
    if (const auto facts = scenario_.PosesAt(*call, why)) return Number(facts->count);
  if (call == nullptr || call->name != "at") return std::nullopt;
  return Number::Whole(ListsPoints(*call) ? static_cast<schema::Integer>(call->arguments.size())
                                          : schema::Integer{1});
}

std::optional<Value> Evaluator::CountObjects() {
  Number objects = Number::Whole(0);
  for (const std::string& group : layers_.groups) {
    const auto quantity = EvaluateParameter({group, schema::GroupParameter("quantity").get()});
    if (!quantity || !AsNumber(*quantity)) return std::nullopt;
    objects = objects + *AsNumber(*quantity);
  }
  // A world without objects still has a cube.
  return objects.AsReal() < 1 ? Number::Whole(1) : objects;
}

std::optional<Value> Evaluator::ConvertFor(const schema::Parameter& parameter, const Value& value,
                                           const Expr& expr, const scenario::Scope& scope) {
  if (const schema::Text* text = AsText(value);
      text != nullptr && parameter.TakesCall(schema::kTraceCall))
    return names::TraceNamed(scenario_, *text, diagnostics_);
  const Expr& origin = sweeps_.Origin(expr, scope);
  std::vector<text::Span> choices;
  if (origin.kind == ExprKind::kCall)
    for (const dsl::Argument& argument : origin.arguments) choices.push_back(argument.value->span);
  return Convert(value, parameter, origin.span, choices, scenario_.plugins(), diagnostics_);
}

namespace {

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

namespace {

using schema::Function;

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
