#include "compiler/evaluate/positive_distributions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/evaluate/evaluate.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using schema::DistributionKind;
using schema::Value;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// An argument and its range.
struct PositiveArgument {
  std::string_view name;
  double least, most;
};

// Draws of lognormal must fit into a double; shapes below 0.01 draw almost only 0.
constexpr PositiveArgument kLognormalArguments[] = {{"mu", -500, 500}, {"sigma", 0, 20}};
constexpr PositiveArgument kExponentialArguments[] = {{"mean", 0, kUnlimited}};
constexpr PositiveArgument kShapeArguments[] = {{"shape", 0.01, 1e6}, {"scale", 0, kUnlimited}};

std::span<const PositiveArgument> ArgumentsFor(DistributionKind kind) {
  if (kind == DistributionKind::kLognormal) return kLognormalArguments;
  if (kind == DistributionKind::kExponential) return kExponentialArguments;
  return kShapeArguments;
}

class PositiveEvaluation {
 public:
  PositiveEvaluation(const dsl::Expr& call, DistributionKind kind, const scenario::Scope& scope,
                     Evaluator& evaluator)
      : call_(call),
        kind_(kind),
        scope_(scope),
        evaluator_(evaluator),
        row_(ArgumentsFor(kind)),
        values_(row_.size()) {}

  std::optional<Value> Evaluate() {
    for (std::size_t i = 0; i < call_.arguments.size(); ++i)
      if (!Add(i)) return std::nullopt;
    if (std::ranges::any_of(values_, [](const auto& value) { return !value; }))
      return Fail(call_.span,
                  fmt::format("{}() takes {} number{}, but there {} {}", call_.text, row_.size(),
                              row_.size() == 1 ? "" : "s",
                              call_.arguments.size() == 1 ? "is" : "are", call_.arguments.size()));
    schema::Distribution drawn{kind_, {}, {}};
    for (const auto& value : values_) drawn.arguments.emplace_back(*value);
    return drawn;
  }

 private:
  std::nullopt_t Fail(const text::Span& span, std::string message) {
    return evaluator_.Error(scenario::kBadArguments, span, std::move(message),
                            std::string(schema::InfoOf(kind_).usage));
  }

  bool Add(std::size_t i) {
    const dsl::Argument& argument = call_.arguments[i];
    if (argument.weight) {
      Fail(argument.weight->span, fmt::format("{}() does not take weights", call_.text));
      return false;
    }
    const bool is_median =
        argument.name && argument.name->text == "median" && kind_ == DistributionKind::kLognormal;
    std::size_t place = is_median ? 0 : i;
    if (argument.name && !is_median)
      place = static_cast<std::size_t>(
          std::ranges::find(row_, argument.name->text, &PositiveArgument::name) - row_.begin());
    if (place >= row_.size()) {
      Fail(argument.name ? argument.name->span : argument.value->span,
           argument.name ? fmt::format("{}() has no argument '{}'", call_.text, argument.name->text)
                         : fmt::format("{}() takes at most {} number{}", call_.text, row_.size(),
                                       row_.size() == 1 ? "" : "s"));
      return false;
    }
    if (values_[place]) {
      Fail(argument.value->span, fmt::format("'{}' is given twice", row_[place].name));
      return false;
    }
    return Evaluate(argument, place, is_median);
  }

  bool Evaluate(const dsl::Argument& argument, std::size_t place, bool is_median) {
    const auto number = evaluator_.EvaluateNumber(*argument.value, scope_, "its arguments");
    if (!number) return false;
    const PositiveArgument& row = row_[place];
    const double value = number->AsReal();
    const bool is_open = row.least == 0 && row.name != "sigma";
    const bool fits = is_median
                          ? value > 0
                          : (is_open ? value > row.least : value >= row.least) && value <= row.most;
    if (fits) {
      values_[place] = is_median ? std::log(value) : value;
      return true;
    }
    std::string wanted = "more than 0";
    if (!is_median && row.most != kUnlimited)
      wanted = fmt::format("from {} to {}", row.least, row.most);
    evaluator_.Error(
        scenario::kOutOfDomain, argument.value->span,
        fmt::format("the {} of {}() must be {}, not {}", is_median ? "median" : row.name,
                    call_.text, wanted, number->Text()));
    return false;
  }

  const dsl::Expr& call_;
  const DistributionKind kind_;
  const scenario::Scope& scope_;
  Evaluator& evaluator_;
  const std::span<const PositiveArgument> row_;
  std::vector<std::optional<double>> values_;
};

}  // namespace

std::optional<Value> EvaluatePositive(const dsl::Expr& call, DistributionKind kind,
                                      const scenario::Scope& scope, Evaluator& evaluator) {
  return PositiveEvaluation(call, kind, scope, evaluator).Evaluate();
}

}  // namespace cdb::evaluate
