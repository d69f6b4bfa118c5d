#include "compiler/evaluate/functions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "compiler/evaluate/evaluate.h"
#include "compiler/evaluate/kind_name.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using schema::Integer;
using schema::Number;
using schema::Value;

using Numbers = std::vector<Number>;

struct Function {
  std::string_view name;
  std::size_t most_arguments;
  Number (*apply)(const Numbers&);
};

constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

template <double (*kRound)(double)>
Number Rounded(const Numbers& x) {
  constexpr double kLargest = 0x1p63;
  if (x[0].is_whole()) return x[0];
  const double rounded = kRound(x[0].AsReal());
  if (std::fabs(rounded) >= kLargest) return rounded;
  return Number::Whole(static_cast<Integer>(rounded));
}

template <double (*kReal)(double)>
Number OfReal(const Numbers& x) {
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
Number Absolute(const Numbers& x) { return IsLess(x[0], Number::Whole(0)) ? -x[0] : x[0]; }
Number Least(const Numbers& x) { return *std::ranges::min_element(x, IsLess); }
Number Most(const Numbers& x) { return *std::ranges::max_element(x, IsLess); }

constexpr auto kFunctions = std::to_array<Function>({{"round", 1, Rounded<RoundReal>},
                                                     {"floor", 1, Rounded<FloorReal>},
                                                     {"ceil", 1, Rounded<CeilReal>},
                                                     {"abs", 1, Absolute},
                                                     {"min", kAnyNumber, Least},
                                                     {"max", kAnyNumber, Most},
                                                     {"sqrt", 1, OfReal<SqrtReal>},
                                                     {"sin", 1, OfReal<SinReal>},
                                                     {"cos", 1, OfReal<CosReal>},
                                                     {"exp", 1, OfReal<ExpReal>},
                                                     {"log", 1, OfReal<LogReal>}});

constexpr auto kNames = [] {
  std::array<std::string_view, kFunctions.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kFunctions[i].name;
  return names;
}();

bool CheckForm(const dsl::Expr& call, const Function& function, Evaluator& evaluator) {
  for (const dsl::Argument& argument : call.arguments) {
    if (!argument.name && !argument.weight) continue;
    evaluator.Error(
        scenario::kBadArguments, argument.name ? argument.name->span : argument.weight->span,
        fmt::format("{}( ) takes numbers alone", function.name), "separate them by commas");
    return false;
  }
  const std::size_t count = call.arguments.size();
  if (count >= 1 && count <= function.most_arguments) return true;
  evaluator.Error(
      scenario::kBadArguments, call.span,
      fmt::format("{}( ) takes {}, here are {}", function.name,
                  function.most_arguments == 1 ? "one number" : "one number or more", count));
  return false;
}

}  // namespace

std::span<const std::string_view> FunctionNames() { return kNames; }

bool IsFunction(std::string_view name) { return std::ranges::find(kNames, name) != kNames.end(); }

std::optional<Value> EvaluateFunction(const dsl::Expr& call, const scenario::Scope& scope,
                                      Evaluator& evaluator) {
  const Function& function = *std::ranges::find(kFunctions, call.text, &Function::name);
  if (!CheckForm(call, function, evaluator)) return std::nullopt;
  Numbers numbers;
  for (const dsl::Argument& argument : call.arguments) {
    const auto value = evaluator.Evaluate(*argument.value, scope);
    if (!value) return std::nullopt;
    if (!AsNumber(*value))
      return evaluator.Error(
          scenario::kWrongKind, argument.value->span,
          fmt::format("{}( ) takes numbers; this is {}", call.text, KindName(*value)));
    numbers.push_back(*AsNumber(*value));
  }
  const double first = numbers[0].AsReal();
  if ((call.text == "sqrt" && first < 0) || (call.text == "log" && first <= 0))
    return evaluator.Error(scenario::kNotFinite, call.span,
                           fmt::format("{}({}) is not a real number", call.text, numbers[0].Text()),
                           fmt::format("{}( ) takes a number {}", call.text,
                                       call.text == "log" ? "more than 0" : "0 or more"));
  const Number result = function.apply(numbers);
  if (std::isfinite(result.AsReal())) return result;
  return evaluator.Error(
      scenario::kNotFinite, call.span,
      fmt::format("{}({}) does not fit into a 64-bit real", call.text, numbers[0].Text()));
}

}  // namespace cdb::evaluate
