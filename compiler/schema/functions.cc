#include "compiler/schema/functions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cdb::schema {
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
    {.name = "abs", .apply = Absolute, .units = FunctionUnits::kSame},
    {.name = "min", .most_arguments = kAnyNumber, .apply = Least, .units = FunctionUnits::kSame},
    {.name = "max", .most_arguments = kAnyNumber, .apply = Most, .units = FunctionUnits::kSame},
    {.name = "sqrt",
     .apply = OfReal<SqrtReal>,
     .domain = {.min = 0},
     .units = FunctionUnits::kRoot},
    {.name = "sin", .apply = OfReal<SinReal>, .units = FunctionUnits::kOfAngle},
    {.name = "cos", .apply = OfReal<CosReal>, .units = FunctionUnits::kOfAngle},
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
