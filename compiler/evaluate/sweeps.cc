#include "compiler/evaluate/sweeps.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "compiler/evaluate/dimensions.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/evaluate/samples.h"
#include "compiler/plan/race.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using dsl::ExprKind;
using schema::Number;
using schema::Value;

const char* ExampleOf(const Expr& call) {
  if (IsFind(call)) return "find(1 .. 1000 log, until: verdict != stable)";
  return IsRace(call) ? "race(sap, dbvt, auto)" : "sweep(1, 2, 5) or sweep(1 .. 5)";
}

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
  if (!IsSweep(expr)) return expr;
  const Sweep* sweep = Find(expr, scope);
  if (sweep == nullptr) return expr;
  const Expr* item = sweep->items[chosen_[&expr]].expr;
  return item != nullptr ? *item : expr;
}

std::optional<Sweep> Sweeps::Expand(const Expr& call, const scenario::Scope& scope) {
  Sweep sweep;
  const Restore guard(is_inside_, true);
  bool good = true;
  sweep.tolerance = IsRace(call) ? plan::kRaceTolerance : kTolerance;
  for (const dsl::Argument& argument : call.arguments)
    if (argument.name) good = TakeNamed(call, argument, scope, sweep) && good;
  if (IsFind(call) && !call.until) {
    evaluator_.Error(scenario::kBadArguments, call.span, "find() has no condition",
                     "for example: find(1 .. 1000 log, until: verdict != stable)");
    good = false;
  }
  if (!IsFind(call) && call.until) {
    evaluator_.Error(
        scenario::kBadArguments, call.until_span,
        "a sweep runs all of its values, and has no condition",
        "to run only those that it takes to find where it begins to hold, write find()");
    good = false;
  }
  for (const dsl::Argument& argument : call.arguments) {
    if (argument.name) continue;
    if (argument.weight) {
      evaluator_.Error(scenario::kBadArguments, argument.weight->span,
                       fmt::format("{}() does not take weights", call.text),
                       "separate the values by commas");
      good = false;
    } else {
      good = AddItems(call, *argument.value, scope, sweep) && good;
    }
  }
  const auto given = std::ranges::find_if(
      call.arguments, [](const dsl::Argument& argument) { return argument.name.has_value(); });
  if (good && IsFind(call) && given != call.arguments.end() && !sweep.has_ladder) {
    evaluator_.Error(scenario::kBadArguments, given->name->span,
                     "these values are given, and no tolerance changes them",
                     "a tolerance is for a range a .. b without step and count: remove it");
    good = false;
  }
  if (good && sweep.items.size() > kMaxAxisValues) {
    evaluator_.Error(scenario::kTooManyRuns, call.span,
                     fmt::format("this sweep has {} values", sweep.items.size()),
                     fmt::format("an axis can have at most {}", kMaxAxisValues));
    good = false;
  }
  if (good && sweep.items.empty()) {
    evaluator_.Error(scenario::kBadArguments, call.span,
                     fmt::format("{}() has no values", call.text), ExampleOf(call));
    good = false;
  }
  if (!good) return std::nullopt;
  return sweep;
}

bool Sweeps::TakeNamed(const Expr& call, const dsl::Argument& argument,
                       const scenario::Scope& scope, Sweep& sweep) {
  // The figure is read with the conditions on figures (checks/requirement_checks.h).
  if (IsRace(call) && argument.name->text == kBy) return true;
  if (call.text == kSweep || argument.name->text != "tolerance") {
    evaluator_.Error(scenario::kBadArguments, argument.name->span,
                     fmt::format("{}() has no argument '{}'", call.text, argument.name->text),
                     IsFind(call)   ? "it has: tolerance, until"
                     : IsRace(call) ? "it has: by, tolerance"
                                    : ExampleOf(call));
    return false;
  }
  const auto number = evaluator_.EvaluateNumber(*argument.value, scope, "a tolerance");
  if (!number) return false;
  sweep.tolerance = number->AsReal();
  if (sweep.tolerance > 0 && sweep.tolerance < 1) return true;
  evaluator_.Error(scenario::kBadArguments, argument.value->span,
                   "a tolerance is a part of a range, or of a value: above 0 and below 1",
                   "for example: tolerance: 5 %");
  return false;
}

bool Sweeps::AddItems(const Expr& call, const Expr& expr, const scenario::Scope& scope,
                      Sweep& sweep) {
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
  if (range != nullptr && IsSampled(range->range)) return AddSamples(call, *range, inner, sweep);
  if (range != nullptr) {
    const bool is_ladder = IsFind(call) && range->range == dsl::RangeKind::kByOne;
    auto numbers = is_ladder ? ExpandLadder(*range, sweep.tolerance, inner, evaluator_)
                             : ExpandRange(*range, inner, evaluator_);
    if (!numbers) return false;
    sweep.has_ladder = sweep.has_ladder || is_ladder;
    const bool is_count =
        scope.parameter != nullptr && scope.parameter->type == schema::ParameterType::kCount;
    if (is_count && (range->is_log || is_ladder)) RoundBetweenEnds(*numbers);
    for (const Number& number : *numbers) sweep.items.push_back({nullptr, number});
    sweep.is_log = range->is_log;
    return true;
  }
  sweep.items.push_back({&expr, std::nullopt});
  // Reported here, since a value with an error might never be chosen.
  return evaluator_.Evaluate(expr, scope).has_value();
}

/// The numbers of one of the sampled ranges of a zip.
bool Sweeps::AddSamples(const Expr& call, const Expr& range, const scenario::Scope& scope,
                        Sweep& sweep) {
  const char* word = range.range == dsl::RangeKind::kSobol ? "sobol" : "latin";
  const auto fail = [&](std::string message, std::string help) {
    evaluator_.Error(scenario::kBadRange, range.span, std::move(message), std::move(help));
    return false;
  };
  if (call.zip == nullptr)
    return fail(fmt::format("'{}' varies several values at once, and this is one", word),
                "write 'count', or let a, b = zip(sweep(1 .. 5 sobol 64), sweep(0 .. 1 sobol 64))");
  if (call.arguments.size() > 1)
    return fail(fmt::format("a range with '{}' is the only argument of its sweep", word), "");
  const auto& sweeps = call.zip->sweeps;
  if (sweeps.size() > kMostDimensions)
    return fail(fmt::format("these are {} values, and '{}' varies at most {}", sweeps.size(), word,
                            kMostDimensions),
                "");
  auto sampled = ExpandSamples(
      range, static_cast<std::size_t>(std::ranges::find(sweeps, &call) - sweeps.begin()), scope,
      evaluator_);
  if (!sampled) return false;
  sweep = *std::move(sampled);
  return true;
}

namespace {

using schema::Integer;

using Numbers = std::vector<Number>;

/// Tolerance at the end of a range, in steps: a step such as 0.1 is not exactly a tenth.
constexpr double kRounding = 1e-9;

std::nullopt_t TooMany(const dsl::Expr& range, double count, Evaluator& evaluator) {
  return evaluator.Error(scenario::kTooManyRuns, range.span,
                         fmt::format("this range has {:.15g} values", count),
                         fmt::format("an axis can have at most {}", kMaxAxisValues));
}

/// The value within a range as one would write it: 0.3, where 3 * 0.1 is 0.30000000000000004, so
/// that a condition such as `x == 0.3` holds. That is the number of 12 digits, if it is no further
/// off than rounding errors; 1/3 stays. `scale`: the largest magnitude that was computed with.
Number WithoutRoundingErrors(const Number& value, double scale) {
  if (value.is_whole()) return value;
  const double real = value.AsReal(), tolerance = 8 * scale * 0x1p-53;
  if (std::fabs(real) <= tolerance) return Number(0.0);
  const std::string digits = fmt::format("{:.12g}", real);
  double written = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), written);
  return std::fabs(written - real) <= tolerance ? Number(written) : value;
}

/// False, with a diagnostic, for a logarithmic range that is not.
bool IsAboveZero(const dsl::Expr& range, const Numbers& bounds, Evaluator& evaluator) {
  if (!range.is_log || (bounds[0].AsReal() > 0 && bounds[1].AsReal() > 0)) return true;
  evaluator.Error(scenario::kBadRange, range.span, "a logarithmic range must be above 0");
  return false;
}

/// Nullopt after a diagnostic. `bounds`: first, last, count.
std::optional<Integer> CountOf(const dsl::Expr& range, const Numbers& bounds,
                               Evaluator& evaluator) {
  const auto count = bounds[2].AsWhole();
  if (!count || *count < 1)
    return evaluator.Error(scenario::kBadRange, range.items[2]->span,
                           "a count must be a whole number, 1 or more");
  if (*count > static_cast<Integer>(kMaxAxisValues))
    return TooMany(range, bounds[2].AsReal(), evaluator);
  if (!IsAboveZero(range, bounds, evaluator)) return std::nullopt;
  return count;
}

Numbers ByCount(const dsl::Expr& range, const Number& first, const Number& last, Integer count) {
  const auto between = [&](Integer i) {
    if (!range.is_log)
      return WithoutRoundingErrors(
          first + (last - first) * Number::Whole(i) / Number::Whole(count - 1),
          std::max(std::fabs(first.AsReal()), std::fabs(last.AsReal())));
    const double low = std::log10(first.AsReal()), high = std::log10(last.AsReal());
    const double part = static_cast<double>(i) / static_cast<double>(count - 1);
    const double value = std::pow(10.0, low + part * (high - low));
    return WithoutRoundingErrors(Number(value), value * (1 + std::fabs(low) + std::fabs(high)));
  };
  // The ends are exactly as written; between them no error accumulates.
  Numbers numbers = {first};
  for (Integer i = 1; i + 1 < count; ++i) numbers.push_back(between(i));
  if (count > 1) numbers.push_back(last);
  return numbers;
}

std::optional<Numbers> BySteps(const dsl::Expr& range, const Number& first, const Number& last,
                               const Number& step, Evaluator& evaluator) {
  if (step.AsReal() == 0)
    return evaluator.Error(scenario::kBadRange, range.items[2]->span,
                           "a range with step 0 never ends");
  const double steps = (last - first).AsReal() / step.AsReal();
  if (steps < 0)
    return evaluator.Error(scenario::kBadRange, range.span,
                           fmt::format("this range is empty: steps of {1} from {0} never reach {2}",
                                       first.Text(), step.Text(), last.Text()),
                           range.range == dsl::RangeKind::kStep ? "change the sign of the step"
                                                                : "to count down, add: step -1");
  const double count = std::floor(steps + kRounding) + 1;
  if (!(count <= static_cast<double>(kMaxAxisValues))) return TooMany(range, count, evaluator);
  const double scale = std::max(std::fabs(first.AsReal()), std::fabs(last.AsReal()));
  Numbers numbers;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const bool at_end = std::fabs(static_cast<double>(i) - steps) <= kRounding;
    numbers.push_back(at_end ? last
                             : WithoutRoundingErrors(
                                   first + step * Number::Whole(static_cast<Integer>(i)), scale));
  }
  return numbers;
}

/// First, last, and the step or count if given; nullopt after a diagnostic.
std::optional<Numbers> BoundsOf(const dsl::Expr& range, const scenario::Scope& scope,
                                Evaluator& evaluator) {
  if (!Dimensions(evaluator.layers(), evaluator).Check(range, scope)) return std::nullopt;
  Numbers bounds;
  for (const auto& item : range.items) {
    const auto number = evaluator.EvaluateNumber(*item, scope, "a range's bounds");
    if (!number) return std::nullopt;
    bounds.push_back(*number);
  }
  return bounds;
}

}  // namespace

std::optional<Numbers> ExpandLadder(const dsl::Expr& range, double tolerance,
                                    const scenario::Scope& scope, Evaluator& evaluator) {
  const auto bounds = BoundsOf(range, scope, evaluator);
  if (!bounds || !IsAboveZero(range, *bounds, evaluator)) return std::nullopt;
  const double first = (*bounds)[0].AsReal(), last = (*bounds)[1].AsReal();
  if (first == last)
    return evaluator.Error(scenario::kBadRange, range.span, "there is nothing between these ends",
                           "a boundary is searched between two different values");
  const double parts =
      range.is_log ? std::fabs(std::log(last / first)) / std::log1p(tolerance) : 1 / tolerance;
  // Rounding errors do not double the parts.
  const double all = std::exp2(std::max(0.0, std::ceil(std::log2(parts) - kRounding)));
  if (!(all < static_cast<double>(kMaxAxisValues))) return TooMany(range, all + 1, evaluator);
  return ByCount(range, (*bounds)[0], (*bounds)[1], static_cast<Integer>(all) + 1);
}

std::optional<Numbers> ExpandRange(const dsl::Expr& range, const scenario::Scope& scope,
                                   Evaluator& evaluator) {
  const auto bounds = BoundsOf(range, scope, evaluator);
  if (!bounds) return std::nullopt;
  using enum dsl::RangeKind;
  if (range.range == kCount) {
    const auto count = CountOf(range, *bounds, evaluator);
    if (!count) return std::nullopt;
    return ByCount(range, (*bounds)[0], (*bounds)[1], *count);
  }
  const Number step = range.range == kStep ? (*bounds)[2] : Number::Whole(1);
  return BySteps(range, (*bounds)[0], (*bounds)[1], step, evaluator);
}

std::optional<Sweep> ExpandSamples(const dsl::Expr& range, std::size_t dimension,
                                   const scenario::Scope& scope, Evaluator& evaluator) {
  const auto bounds = BoundsOf(range, scope, evaluator);
  const auto count = bounds ? CountOf(range, *bounds, evaluator) : std::nullopt;
  if (!count) return std::nullopt;
  const auto size = static_cast<std::size_t>(*count);
  const double first = (*bounds)[0].AsReal(), last = (*bounds)[1].AsReal();
  Sweep sweep{{}, range.range, {first, last}, range.is_log};
  for (const double part : range.range == dsl::RangeKind::kSobol
                               ? SobolCoordinates(dimension, size)
                               : LatinCoordinates(dimension, size))
    sweep.items.push_back({nullptr, Number(range.is_log ? first * std::pow(last / first, part)
                                                        : first + part * (last - first))});
  return sweep;
}

void RoundBetweenEnds(std::vector<Number>& numbers) {
  Numbers rounded;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const bool is_end = i == 0 || i + 1 == numbers.size();
    // Larger numbers are rejected as counts.
    const double real = std::round(numbers[i].AsReal());
    const bool fits = std::abs(real) < 0x1p63;
    const Number number = is_end || !fits ? numbers[i] : Number::Whole(static_cast<Integer>(real));
    if (rounded.empty() || Compare(rounded.back(), number) != 0) rounded.push_back(number);
  }
  numbers = std::move(rounded);
}

}  // namespace cdb::evaluate
