#include "compiler/evaluate/dimensions.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/distributions.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/names/names.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/formula.h"
#include "dsl/text/check.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using dsl::ExprKind;
using text::Unit;

constexpr std::pair<std::string_view, std::string_view> kNamedDimensions[] = {
    {"m", "a length"},
    {"kg", "a mass"},
    {"s", "a time"},
    {"rad", "an angle"},
    {"m/s", "a velocity"},
    {"rad/s", "an angular velocity"},
    {"m/s^2", "an acceleration"},
    {"Hz", "a frequency"},
    {"kg/m^3", "a density"},
    {"m^2", "an area"},
    {"m^3", "a volume"},
    {"N", "a force"},
    {"N m", "a torque"},
    {"N m s/rad", "a rotational damping"},
    {"N/m", "a stiffness"},
    {"N s/m", "a damping"},
    {"Pa", "a pressure"},
    {"B", "a number of bytes"}};

/// A unit as text in base units: `kg m/s^2`.
std::string BaseUnits(const Unit& unit) {
  const std::pair<const char*, int> powers[] = {{"kg", unit.mass},
                                                {"m", unit.length},
                                                {"rad", unit.angle},
                                                {"s", unit.time},
                                                {"B", unit.memory}};
  std::string above, below;
  for (const auto& [name, power] : powers) {
    if (power == 0) continue;
    std::string& side = power > 0 ? above : below;
    if (power < 0) side += '/';
    if (power > 0 && !side.empty()) side += ' ';
    side += std::abs(power) == 1 ? name : fmt::format("{}^{}", name, std::abs(power));
  }
  return (above.empty() ? "1" : above) + below;
}

Unit SchemaUnit(std::string_view text) {
  const auto unit = text::ParseUnit(text);
  CDB_CHECK(unit.has_value());
  return *unit;
}

/// The exponent of a power, if it is an integer literal from -9 to 9.
std::optional<int> WrittenPower(const Expr& expr) {
  const bool is_negative = expr.kind == ExprKind::kNegate;
  const Expr& number = is_negative ? *expr.items[0] : expr;
  if (number.kind != ExprKind::kNumber || number.text.size() != 1) return std::nullopt;
  const int power = number.text[0] - '0';
  return is_negative ? -power : power;
}

}  // namespace

std::string DimensionName(const Unit& unit) {
  if (unit.IsPure()) return "a number without a unit";
  for (const auto& [text, name] : kNamedDimensions)
    if (SchemaUnit(text).HasDimensionOf(unit)) return std::string(name);
  return "in " + BaseUnits(unit);
}

std::set<scenario::ParameterKey> Dimensions::CheckAll() {
  std::set<scenario::ParameterKey> faulty;
  for (const auto& [key, setting] : layers_.settings) {
    is_faulty_ = false;
    for (const auto& value : setting.node->values)
      CheckFor(*key.second, UnitOf(key, evaluator_), *value, setting.scope);
    if (is_faulty_) faulty.insert(key);
  }
  for (const auto& [key, let] : layers_.lets) CheckLet(*let.node, let.scope);
  for (const auto& skip : layers_.skips)
    if (skip.node->when) Check(*skip.node->when, skip.scope);
  return faulty;
}

void Dimensions::CheckLet(const dsl::Let& let, const scenario::Scope& scope) {
  const auto [known, is_new] = lets_.emplace(&let, Dimension{});
  if (!is_new) return;
  const Dimension dimension = Find(*let.value, scope);
  lets_[&let] = dimension;
}

bool Dimensions::Check(const Expr& expr, const scenario::Scope& scope) {
  is_faulty_ = false;
  Find(expr, scope);
  return !is_faulty_;
}

Dimensions::Dimension Dimensions::Report(const text::Span& span, std::string message,
                                         std::string help) {
  is_faulty_ = true;
  evaluator_.Error(scenario::kWrongUnit, span, std::move(message), std::move(help));
  return {};
}

void Dimensions::CheckFor(const schema::Parameter& parameter, std::string_view unit,
                          const Expr& expr, const scenario::Scope& scope) {
  const Dimension found = Find(expr, scope);
  using enum schema::ParameterType;
  const bool takes_numbers = parameter.type == kCount || parameter.type == kReal ||
                             parameter.type == kVector || parameter.type == kRatio;
  if (takes_numbers) Require(parameter.name, unit, found, expr);
}

bool Dimensions::CheckFor(std::string_view name, std::string_view unit, const Expr& expr,
                          const scenario::Scope& scope) {
  is_faulty_ = false;
  const Dimension found = Find(expr, scope);
  if (!is_faulty_) Require(name, unit, found, expr);
  return !is_faulty_;
}

void Dimensions::Require(std::string_view name, std::string_view unit, const Dimension& found,
                         const Expr& expr) {
  if (found.kind != Kind::kUnit) return;
  const Unit wanted = SchemaUnit(unit);
  if (wanted.HasDimensionOf(found.unit)) return;
  if (wanted.IsPure()) {
    Report(expr.span,
           fmt::format("'{}' has no unit, but this is {}", name, DimensionName(found.unit)));
  } else {
    const bool is_rate = expr.kind == ExprKind::kQuantity && expr.text == "Hz" && unit == "s";
    Report(expr.span,
           fmt::format("'{}' is {}, but this is {}", name, DimensionName(wanted),
                       DimensionName(found.unit)),
           is_rate ? fmt::format("write 1/{} s", text::TextOf(expr.items[0]->span))
                   : fmt::format("a number without a unit is in {}", unit));
  }
}

Dimensions::Dimension Dimensions::Find(const Expr& expr, const scenario::Scope& scope) {
  switch (expr.kind) {
    case ExprKind::kNumber: {
      const auto number = schema::Number::FromLiteral(expr.text);
      return {number && number->AsReal() == 0 ? Kind::kZero : Kind::kPure, {}};
    }
    case ExprKind::kPath:
      return FindPath(expr, scope);
    case ExprKind::kVector:
    case ExprKind::kRatio:
      return Join(ItemsOf(expr, scope, expr.items.size()));
    case ExprKind::kCall:
      return FindCall(expr, scope);
    case ExprKind::kNegate:
      return Find(*expr.items[0], scope);
    case ExprKind::kBinary:
      return FindBinary(expr, scope);
    case ExprKind::kRange:
      return FindRange(expr, scope);
    case ExprKind::kQuantity:
      return FindQuantity(expr, scope);
    case ExprKind::kText:
    case ExprKind::kError:
      break;
  }
  return {};
}

Dimensions::Dimension Dimensions::FindPath(const Expr& expr, const scenario::Scope& scope) {
  const names::Referent referent = evaluator_.names().Resolve(expr.text, scope);
  if (referent.parameter && IsDrawn(*referent.parameter))
    return {Kind::kDrawn, SchemaUnit(referent.parameter->second->unit)};
  if (!referent.let) return {};
  CheckLet(*referent.let->node, referent.let->scope);
  return lets_[referent.let->node];
}

bool Dimensions::IsDrawn(const scenario::ParameterKey& key) {
  const auto set = layers_.settings.find(key);
  if (set == layers_.settings.end() || key.second->type != schema::ParameterType::kReal)
    return false;
  const auto [known, is_new] = drawn_.emplace(set->second.node, false);
  if (!is_new) return known->second;
  for (const auto& value : set->second.node->values)
    if (IsDrawn(*value, set->second.scope)) return drawn_[set->second.node] = true;
  return false;
}

bool Dimensions::NamesDrawn(const Expr& path, const scenario::Scope& scope) {
  constexpr int kMostDepth = 500;  // the evaluator rejects longer chains
  const names::Referent referent = evaluator_.names().Resolve(path.text, scope);
  if (depth_ >= kMostDepth || referent.IsWord() || referent.is_object_count || referent.measure)
    return false;
  ++depth_;
  bool is_drawn = false;
  if (referent.parameter) {
    is_drawn = IsDrawn(*referent.parameter);
  } else if (const auto [known, is_new] = drawn_.emplace(referent.let->node, false); is_new) {
    is_drawn = drawn_[referent.let->node] =
        IsDrawn(*referent.let->node->value, referent.let->scope);
  } else {
    is_drawn = known->second;
  }
  --depth_;
  return is_drawn;
}

bool Dimensions::IsDrawn(const Expr& expr, const scenario::Scope& scope) {
  if (expr.kind == ExprKind::kPath) return NamesDrawn(expr, scope);
  const bool is_call = expr.kind == ExprKind::kCall;
  if (is_call &&
      (schema::FindDistribution(expr.text) || expr.text == "same" || expr.text == "density"))
    return true;
  return std::ranges::any_of(expr.items, [&](const auto& item) { return IsDrawn(*item, scope); }) ||
         std::ranges::any_of(expr.arguments, [&](const dsl::Argument& argument) {
           return IsDrawn(*argument.value, scope);
         });
}

Dimensions::Dimension Dimensions::FindBinary(const Expr& expr, const scenario::Scope& scope) {
  const Parts parts = ItemsOf(expr, scope, 2);
  if (expr.op == '+' || expr.op == '-') return Join(parts);
  const Dimension &left = parts[0].dimension, &right = parts[1].dimension;
  if (expr.op == '^') return FindPower(expr, left, right);
  if (left.kind == Kind::kUnknown || right.kind == Kind::kUnknown) return {};
  const Unit unit = text::Multiplied(left.unit, right.unit, expr.op == '*' ? 1 : -1);
  const auto either = [&](Kind kind) { return left.kind == kind || right.kind == kind; };
  if (either(Kind::kUnit)) return Of(unit);
  if (either(Kind::kDrawn)) return {Kind::kDrawn, unit};
  return left.kind == Kind::kZero ? left : Of(unit);
}

Dimensions::Dimension Dimensions::FindPower(const Expr& expr, const Dimension& base,
                                            const Dimension& exponent) {
  RequirePure({exponent, expr.items[1]->span}, "an exponent");
  const auto power = WrittenPower(*expr.items[1]);
  if (base.kind == Kind::kDrawn && power)
    return {Kind::kDrawn, text::Multiplied({}, base.unit, *power)};
  if (base.kind == Kind::kDrawn) return {};
  if (base.kind != Kind::kUnit) return base;
  if (power) return Of(text::Multiplied({}, base.unit, *power));
  return Report(expr.items[1]->span,
                "the exponent of a value with a unit must be a whole number from -9 to 9");
}

Dimensions::Dimension Dimensions::FindQuantity(const Expr& expr, const scenario::Scope& scope) {
  const Dimension value = Find(*expr.items[0], scope);
  if (value.kind == Kind::kUnit || value.kind == Kind::kDrawn)
    return Report(expr.text_span,
                  fmt::format("this already has a unit: it is {}", DimensionName(value.unit)));
  return Of(*text::ParseUnit(expr.text));
}

Dimensions::Dimension Dimensions::FindRange(const Expr& expr, const scenario::Scope& scope) {
  const bool has_count =
      expr.range != dsl::RangeKind::kByOne && expr.range != dsl::RangeKind::kStep;
  if (has_count) RequirePure({Find(*expr.items[2], scope), expr.items[2]->span}, "a count");
  Parts parts = ItemsOf(expr, scope, has_count ? 2 : expr.items.size());
  // `0 .. 10 cm` counts in steps of one metre.
  const bool by_one =
      expr.range == dsl::RangeKind::kByOne && std::ranges::any_of(parts, [](const Part& part) {
        return part.dimension.kind == Kind::kUnit;
      });
  const Dimension joined = Join(parts);
  // `log` alone is of a search, which divides the range.
  if (by_one && !expr.is_log && joined.kind == Kind::kUnit)
    return Report(expr.span, "a range with units needs a step or a count",
                  "write 1 cm .. 5 cm step 1 cm, or sweep(1 .. 5) cm");
  return joined;
}

Dimensions::Parts Dimensions::ItemsOf(const Expr& expr, const scenario::Scope& scope,
                                      std::size_t count) {
  Parts parts;
  for (std::size_t i = 0; i < count; ++i)
    parts.push_back({Find(*expr.items[i], scope), expr.items[i]->span});
  return parts;
}

Dimensions::Parts Dimensions::ArgumentsOf(const Expr& call, const scenario::Scope& scope) {
  Parts parts;
  for (const dsl::Argument& argument : call.arguments) {
    if (IsRace(call) && argument.name && argument.name->text == kBy) continue;
    if ((IsFind(call) || IsRace(call)) && argument.name) {
      RequirePure({Find(*argument.value, scope), argument.value->span}, "a tolerance");
      continue;
    }
    parts.push_back({Find(*argument.value, scope), argument.value->span});
    if (argument.weight)
      RequirePure({Find(*argument.weight, scope), argument.weight->span}, "a weight");
  }
  return parts;
}

Dimensions::Dimension Dimensions::FindCall(const Expr& expr, const scenario::Scope& scope) {
  if (const schema::ParametrisedWord* info = schema::FindParametrisedWord(expr.text)) {
    CheckWord(expr, *info, scope);
    return {};
  }
  if (IsFunction(expr.text)) return FindFunction(expr, scope);
  if (!IsSweep(expr) && !schema::FindDistribution(expr.text)) return {};
  Parts parts = ItemsOf(expr, scope, expr.items.size());
  parts.push_back({FindDrawn(expr, scope), expr.span});
  return Join(parts);
}

/// The dimension of the draws themselves, without their limits.
Dimensions::Dimension Dimensions::FindDrawn(const Expr& expr, const scenario::Scope& scope) {
  if (expr.text == "empirical") {
    const auto unit = UnitOfEmpirical(expr, scope, evaluator_);
    return unit ? Of(*unit) : Dimension{};
  }
  if (expr.text == "normal") return FindNormal(expr, scope);
  if (expr.text == "empirical") return {};
  const Parts parts = ArgumentsOf(expr, scope);
  const bool has_shape = expr.text == "gamma" || expr.text == "weibull";
  if (expr.text != "lognormal" && !has_shape) return Join(parts);
  Dimension found = Pure();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& name = expr.arguments[i].name;
    const bool is_median = name && name->text == "median";
    const bool is_scale = has_shape && (name ? name->text == "scale" : i == 1);
    if (is_median || is_scale) {
      found = parts[i].dimension;
    } else {
      RequirePure(parts[i], has_shape ? "a shape" : "a logarithm");
    }
  }
  return found;
}

Dimensions::Dimension Dimensions::FindFunction(const Expr& expr, const scenario::Scope& scope) {
  const Parts parts = ArgumentsOf(expr, scope);
  const schema::UnitRule rule = schema::FindFunction(expr.text)->units;
  if (rule == schema::UnitRule::kSame) return Join(parts);
  if (parts.size() != 1) return {};  // reported by the evaluator
  const Dimension& of = parts[0].dimension;
  if (of.kind == Kind::kDrawn) return {};
  if (of.kind != Kind::kUnit) return of;
  const Unit& unit = of.unit;
  if (rule == schema::UnitRule::kRoot) {
    const Unit root = {.length = unit.length / 2,
                       .mass = unit.mass / 2,
                       .time = unit.time / 2,
                       .angle = unit.angle / 2,
                       .memory = unit.memory / 2};
    if (text::Multiplied({}, root, 2).HasDimensionOf(unit)) return Of(root);
    return Report(parts[0].span,
                  fmt::format("the root of {} is not a whole power of units", DimensionName(unit)));
  }
  if (rule == schema::UnitRule::kAngle && unit.HasDimensionOf(SchemaUnit("rad"))) return Pure();
  return Report(parts[0].span, fmt::format("{}() takes a number without a unit, but this is {}",
                                           expr.text, DimensionName(unit)));
}

Dimensions::Dimension Dimensions::FindNormal(const Expr& expr, const scenario::Scope& scope) {
  Parts parts = ArgumentsOf(expr, scope);
  const bool is_variance =
      parts.size() == 2 && expr.arguments[1].name && expr.arguments[1].name->text == "variance";
  if (!is_variance || parts[0].dimension.kind != Kind::kUnit ||
      parts[1].dimension.kind != Kind::kUnit)
    return Join(parts);
  const Unit square = text::Multiplied({}, parts[0].dimension.unit, 2);
  if (square.HasDimensionOf(parts[1].dimension.unit)) return parts[0].dimension;
  return Report(parts[1].span,
                fmt::format("this variance is {}, but the variance of {} is {}",
                            DimensionName(parts[1].dimension.unit),
                            DimensionName(parts[0].dimension.unit), DimensionName(square)));
}

void Dimensions::CheckWord(const Expr& call, const schema::ParametrisedWord& info,
                           const scenario::Scope& scope) {
  for (std::size_t i = 0; i < call.arguments.size(); ++i) {
    const schema::Parameter* argument = names::ArgumentAt(info, call, i);
    if (argument == nullptr) continue;
    const bool takes_parameters_unit = argument->unit == schema::kParametersUnit;
    if (takes_parameters_unit && scope.parameter == nullptr) continue;
    CheckFor(takes_parameters_unit ? *scope.parameter : *argument,
             takes_parameters_unit ? scope.parameter->unit : argument->unit,
             *call.arguments[i].value, names::ArgumentScope(call, i, scope));
  }
}

Dimensions::Dimension Dimensions::Join(const Parts& parts) {
  const auto is = [](Kind kind) {
    return [kind](const Part& part) { return part.dimension.kind == kind; };
  };
  const auto first = std::ranges::find_if(parts, is(Kind::kUnit));
  if (first == parts.end()) return JoinWithoutUnit(parts);
  for (const Part& part : parts) {
    if (part.dimension.kind == Kind::kPure)
      return Report(part.span,
                    fmt::format("this has no unit, but the value beside it is {}",
                                DimensionName(first->dimension.unit)),
                    "write the unit after each of them, or once after the parentheses");
    if ((part.dimension.kind == Kind::kUnit || part.dimension.kind == Kind::kDrawn) &&
        !part.dimension.unit.HasDimensionOf(first->dimension.unit))
      return Report(part.span, fmt::format("this is {}, but the value beside it is {}",
                                           DimensionName(part.dimension.unit),
                                           DimensionName(first->dimension.unit)));
  }
  return first->dimension;
}

Dimensions::Dimension Dimensions::JoinWithoutUnit(const Parts& parts) {
  const Dimension* drawn = nullptr;
  Kind kind = parts.empty() ? Kind::kUnknown : Kind::kZero;
  for (const Part& part : parts) {
    const Dimension& dimension = part.dimension;
    if (dimension.kind == Kind::kUnknown) return {};
    if (dimension.kind == Kind::kPure) kind = Kind::kPure;
    if (dimension.kind != Kind::kDrawn) continue;
    if (drawn != nullptr && !drawn->unit.HasDimensionOf(dimension.unit)) return {};
    drawn = &dimension;
  }
  // Plain numbers beside it are in its unit, as everywhere.
  return drawn != nullptr ? *drawn : Dimension{kind, {}};
}

void Dimensions::RequirePure(const Part& part, const char* what) {
  if (part.dimension.kind == Kind::kUnit)
    Report(part.span,
           fmt::format("{} has no unit, but this is {}", what, DimensionName(part.dimension.unit)));
}

void Dimensions::Check(const dsl::Condition& condition, const scenario::Scope& scope) {
  for (const auto& item : condition.items) Check(*item, scope);
  if (!condition.left || !condition.right) return;
  const auto left = SideOf(*condition.left, scope), right = SideOf(*condition.right, scope);
  if (left && right && !left->HasDimensionOf(*right))
    Report(condition.right->span, fmt::format("this is {}, but it is compared with {}",
                                              DimensionName(*right), DimensionName(*left)));
}

std::optional<Unit> Dimensions::SideOf(const Expr& expr, const scenario::Scope& scope) {
  const Dimension dimension = Find(expr, scope);
  if (dimension.kind == Kind::kUnit) return dimension.unit;
  if (expr.kind != ExprKind::kPath) return std::nullopt;
  const names::Referent referent = evaluator_.names().Resolve(expr.text, scope);
  if (referent.let || !referent.parameter) return std::nullopt;
  return SchemaUnit(referent.parameter->second->unit);
}

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
  const Expr& inner = *expr.items[0];
  const bool is_call = AsCall(value) != nullptr && inner.kind == ExprKind::kCall;
  return evaluator.Error(scenario::kWrongUnit, expr.text_span,
                         fmt::format("{} has no unit", names::KindName(value)),
                         is_call && inner.arguments.size() == 1
                             ? fmt::format("write {}({} {})", inner.text,
                                           text::TextOf(inner.arguments[0].value->span), expr.text)
                             : "");
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
