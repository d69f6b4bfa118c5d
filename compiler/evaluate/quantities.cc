#include "compiler/evaluate/quantities.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "compiler/evaluate/drawn_settings.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/evaluate/functions.h"
#include "compiler/names/kind_name.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "dsl/text/check.h"

namespace cdb::evaluate {
namespace {

using schema::Integer;
using schema::Number;
using schema::Value;

/// The difference of pi and kPi.
constexpr double kPiRest = 1.2246467991473532e-16;

/// Digits, without a point, times ten to the power of `exponent`.
struct Decimal {
  Integer digits = 0;
  int exponent = 0;
};

/// Parses the text of a finite number without a sign.
Decimal DecimalOf(std::string_view text) {
  Decimal decimal;
  bool is_fraction = false;
  std::size_t i = 0;
  for (; i < text.size() && text[i] != 'e'; ++i) {
    if (text[i] == '.') {
      is_fraction = true;
      continue;
    }
    decimal.digits = decimal.digits * 10 + (text[i] - '0');
    decimal.exponent -= is_fraction ? 1 : 0;
  }
  if (i < text.size()) {
    std::string_view power = text.substr(i + 1);
    if (power.starts_with('+')) power.remove_prefix(1);
    int value = 0;
    std::from_chars(power.data(), power.data() + power.size(), value);
    decimal.exponent += value;
  }
  return decimal;
}

Number ToNumber(const Decimal& decimal) {
  if (decimal.exponent == 0) return Number::Whole(decimal.digits);
  const std::string text = fmt::format("{}e{}", decimal.digits, decimal.exponent);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range)
    value = decimal.exponent > 0 ? std::numeric_limits<double>::infinity() : 0;
  return value;
}

/// `value * pi / divisor` with about one rounding: the products carry their rounding errors.
double TimesPi(double value, double divisor) {
  const double product = value * kPi;
  const double rest = std::fma(value, kPi, -product) + value * kPiRest;
  const double quotient = product / divisor;
  return quotient + (std::fma(-quotient, divisor, product) + rest) / divisor;
}

std::optional<Value> ScaledDistribution(const dsl::Expr& expr, const text::Unit& unit,
                                        schema::Distribution drawn, Evaluator& evaluator);

std::optional<Value> Scaled(const dsl::Expr& expr, const text::Unit& unit, const Value& value,
                            Evaluator& evaluator) {
  if (AsNumber(value)) return InSi(*AsNumber(value), unit);
  if (AsVector(value)) {
    Eigen::Vector3d scaled;
    for (int i = 0; i < 3; ++i) scaled[i] = InSi(Number((*AsVector(value))[i]), unit).AsReal();
    return Value(scaled);
  }
  if (AsDistribution(value))
    return ScaledDistribution(expr, unit, *AsDistribution(value), evaluator);
  if (AsFormula(value))
    return MakeFormula("*", {value, InSi(Number::Whole(1), unit)}, expr.span, evaluator);
  return evaluator.Error(scenario::kWrongUnit, expr.text_span,
                         fmt::format("{} has no unit", names::KindName(value)));
}

std::optional<Value> ScaledDistribution(const dsl::Expr& expr, const text::Unit& unit,
                                        schema::Distribution drawn, Evaluator& evaluator) {
  using enum schema::DistributionKind;
  if (drawn.kind == kLognormal) {
    // The mean of the logarithm: a factor shifts it.
    const double factor = InSi(Number::Whole(1), unit).AsReal();
    drawn.arguments[0] = AsNumber(drawn.arguments[0])->AsReal() + std::log(factor);
  }
  const bool has_shape = drawn.kind == kGamma || drawn.kind == kWeibull;
  for (Value& argument : drawn.arguments) {
    if (drawn.kind == kLognormal || (has_shape && &argument == &drawn.arguments[0])) continue;
    auto scaled = Scaled(expr, unit, argument, evaluator);
    if (!scaled) return std::nullopt;
    argument = *scaled;
  }
  if (drawn.limits)
    drawn.limits = schema::Limits{InSi(drawn.limits->least, unit).AsReal(),
                                  InSi(drawn.limits->most, unit).AsReal()};
  return drawn;
}

}  // namespace

Number InSi(const Number& number, const text::Unit& unit) {
  constexpr double kMostFactor = 1e15;
  const std::string text = number.Text();
  const bool is_negative = text.starts_with('-');
  const double real = number.AsReal();
  if (!std::isfinite(real)) return number;
  Decimal decimal = DecimalOf(std::string_view(text).substr(is_negative ? 1 : 0));
  decimal.exponent += unit.tens;
  Integer product = 0;
  const bool is_exact =
      unit.factor <= kMostFactor &&
      !__builtin_mul_overflow(decimal.digits, static_cast<Integer>(unit.factor), &product);
  if (is_exact) decimal.digits = product;
  // 5 km become the integer 5000; 50 mm are not an integer, but 5000 mm are.
  for (; decimal.exponent > 0 && number.is_whole() && decimal.digits < Integer{1} << 64;
       --decimal.exponent)
    decimal.digits *= 10;
  for (; decimal.exponent < 0 && decimal.digits % 10 == 0 && decimal.digits != 0;
       ++decimal.exponent)
    decimal.digits /= 10;
  Number scaled = ToNumber(decimal);
  if (!is_exact) scaled = scaled.AsReal() * unit.factor;
  if (unit.pis == 1) {
    scaled = TimesPi(scaled.AsReal(), unit.divisor);
  } else if (unit.divisor != 1 || unit.pis != 0) {
    scaled = scaled.AsReal() / unit.divisor * std::pow(kPi, unit.pis);
  }
  return is_negative ? -scaled : scaled;
}

std::optional<Value> EvaluateQuantity(const dsl::Expr& expr, const scenario::Scope& scope,
                                      Evaluator& evaluator) {
  const auto unit = text::ParseUnit(expr.text);
  CDB_CHECK(unit.has_value());  // the parser accepts no other unit
  const auto value = evaluator.Evaluate(*expr.items[0], scope);
  if (!value) return std::nullopt;
  return Scaled(expr, *unit, *value, evaluator);
}

}  // namespace cdb::evaluate
