#include "compiler/schema/formula.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dsl/text/check.h"

namespace cdb::schema {
namespace {

constexpr std::string_view kOperators = "+-*/^";

bool IsOperator(std::string_view op) {
  return op.size() == 1 && kOperators.find(op[0]) != std::string_view::npos;
}

/// Precedence; sums bind loosest.
constexpr int kSum = 1, kProduct = 2, kPower = 3, kPrimary = 4;
int BindingOf(const Value& value) {
  const Formula* formula = AsFormula(value);
  if (formula == nullptr || !IsOperator(formula->op) || formula->arguments.size() == 1)
    return kPrimary;
  switch (formula->op[0]) {
    case '+':
    case '-':
      return kSum;
    case '^':
      return kPower;
    default:
      return kProduct;
  }
}

std::string Bracketed(const Value& value, bool needs_brackets) {
  const std::string text = ToText(value);
  return needs_brackets ? "(" + text + ")" : text;
}

/// a - (b - c) and (a ^ b) ^ c need their brackets.
std::string OperatorText(const Formula& formula) {
  const Value &left = formula.arguments[0], &right = formula.arguments[1];
  const int binding = BindingOf(formula);
  const bool is_power = formula.op == "^";
  return fmt::format("{} {} {}", Bracketed(left, BindingOf(left) < binding + (is_power ? 1 : 0)),
                     formula.op, Bracketed(right, BindingOf(right) < binding + (is_power ? 0 : 1)));
}

void AddSettings(const Value& value, std::vector<const Formula*>& settings) {
  const Formula* formula = AsFormula(value);
  if (formula == nullptr) return;
  if (formula->op.empty()) settings.push_back(formula);
  for (const Value& argument : formula->arguments) AddSettings(argument, settings);
}

}  // namespace

std::size_t FormulaParts(const Value& value) {
  std::size_t parts = 1;
  if (const Formula* formula = AsFormula(value))
    for (const Value& argument : formula->arguments) parts += FormulaParts(argument);
  return parts;
}

bool IsFormulaOp(std::string_view op, std::size_t arguments) {
  if (const Function* function = FindFunction(op))
    return arguments >= 1 && arguments <= function->most_arguments;
  return IsOperator(op) && (arguments == 2 || (op == "-" && arguments == 1));
}

std::vector<const Formula*> SettingsIn(const Value& value) {
  std::vector<const Formula*> settings;
  AddSettings(value, settings);
  return settings;
}

std::string FormulaText(const Formula& formula) {
  if (formula.op.empty()) return formula.setting;
  if (FindFunction(formula.op) != nullptr) {
    std::string text;
    for (const Value& argument : formula.arguments)
      text += (text.empty() ? "" : ", ") + ToText(argument);
    return fmt::format("{}({})", formula.op, text);
  }
  if (formula.arguments.size() == 2) return OperatorText(formula);
  const Value& negated = formula.arguments[0];
  return "-" + Bracketed(negated, BindingOf(negated) < kPrimary);
}

FormulaProgram::FormulaProgram(const Value& value, std::span<const std::string_view> names) {
  Add(value, names);
}

void FormulaProgram::Add(const Value& value, std::span<const std::string_view> names) {
  using enum Step::Kind;
  if (const Number* number = AsNumber(value))
    return steps_.push_back({.kind = kNumber, .number = number->AsReal()});
  const Formula* formula = AsFormula(value);
  CDB_CHECK(formula != nullptr);
  if (formula->op.empty()) {
    const auto name = std::ranges::find(names, formula->setting);
    CDB_CHECK(name != names.end());
    return steps_.push_back(
        {.kind = kName, .count = static_cast<std::size_t>(name - names.begin())});
  }
  for (const Value& argument : formula->arguments) Add(argument, names);
  Step step{.kind = kOperator, .count = formula->arguments.size(), .op = formula->op[0]};
  if (const Function* function = FindFunction(formula->op)) {
    step.kind = kFunction;
    step.apply = function->apply;
  } else if (step.count == 1) {
    step.kind = kNegation;
  }
  steps_.push_back(step);
}

double FormulaProgram::operator()(std::span<const double> values) {
  stack_.clear();
  for (const Step& step : steps_) {
    const std::size_t below = stack_.size() - (step.kind > Step::Kind::kName ? step.count : 0);
    Number result = step.number;
    switch (step.kind) {
      case Step::Kind::kNumber:
        break;
      case Step::Kind::kName:
        result = values[step.count];
        break;
      case Step::Kind::kFunction:
        result = step.apply(std::span<const Number>(stack_).subspan(below));
        break;
      case Step::Kind::kOperator:
        result = Calculate(step.op, stack_[below], stack_[below + 1]);
        break;
      case Step::Kind::kNegation:
        result = -stack_[below];
        break;
    }
    stack_.erase(stack_.begin() + static_cast<std::ptrdiff_t>(below), stack_.end());
    stack_.push_back(result);
  }
  return stack_.back().AsReal();
}

double Evaluate(const Formula& formula, const std::function<double(std::string_view)>& value_of) {
  std::vector<std::string_view> names;
  std::vector<double> values;
  const Value value = formula;
  for (const Formula* name : SettingsIn(value)) {
    if (std::ranges::find(names, name->setting) != names.end()) continue;
    names.push_back(name->setting);
    values.push_back(value_of(name->setting));
  }
  return FormulaProgram(value, names)(values);
}

namespace {

using Numbers = std::span<const Number>;

constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

template <double (*kRound)(double)>
Number Rounded(Numbers x) {
  constexpr double kLargest = 0x1p63;
  if (x[0].is_whole()) return x[0];
  const double rounded = kRound(x[0].AsReal());
  if (!(std::fabs(rounded) < kLargest)) return rounded;
  return Number::Whole(static_cast<Integer>(rounded));
}

template <double (*kReal)(double)>
Number OfReal(Numbers x) {
  return kReal(x[0].AsReal());
}

bool IsLess(const Number& a, const Number& b) { return Compare(a, b) < 0; }

double RoundReal(double x) { return std::round(x); }
double FloorReal(double x) { return std::floor(x); }
double CeilReal(double x) { return std::ceil(x); }
double SqrtReal(double x) { return std::sqrt(x); }
double SinReal(double x) { return std::sin(x); }
double CosReal(double x) { return std::cos(x); }
double ExpReal(double x) { return std::exp(x); }
double LogReal(double x) { return std::log(x); }
Number Absolute(Numbers x) { return IsLess(x[0], Number::Whole(0)) ? -x[0] : x[0]; }
Number Least(Numbers x) { return *std::ranges::min_element(x, IsLess); }
Number Most(Numbers x) { return *std::ranges::max_element(x, IsLess); }

constexpr auto kFunctions = std::to_array<Function>({
    {.name = "round", .apply = Rounded<RoundReal>},
    {.name = "floor", .apply = Rounded<FloorReal>},
    {.name = "ceil", .apply = Rounded<CeilReal>},
    {.name = "abs", .apply = Absolute, .units = UnitRule::kSame},
    {.name = "min", .most_arguments = kAnyNumber, .apply = Least, .units = UnitRule::kSame},
    {.name = "max", .most_arguments = kAnyNumber, .apply = Most, .units = UnitRule::kSame},
    {.name = "sqrt", .apply = OfReal<SqrtReal>, .units = UnitRule::kRoot, .domain = {.min = 0}},
    {.name = "sin", .apply = OfReal<SinReal>, .units = UnitRule::kAngle},
    {.name = "cos", .apply = OfReal<CosReal>, .units = UnitRule::kAngle},
    {.name = "exp", .apply = OfReal<ExpReal>},
    {.name = "log", .apply = OfReal<LogReal>, .domain = {.min = 0, .min_open = true}},
});

}  // namespace

std::span<const Function> Functions() { return kFunctions; }

const Function* FindFunction(std::string_view name) {
  const auto* row = std::ranges::find(kFunctions, name, &Function::name);
  return row == kFunctions.end() ? nullptr : row;
}

Number Calculate(char op, const Number& a, const Number& b) {
  switch (op) {
    case '+':
      return a + b;
    case '-':
      return a - b;
    case '*':
      return a * b;
    case '/':
      return a / b;
    default:
      return Power(a, b);
  }
}

}  // namespace cdb::schema
