#include "compiler/evaluate/distributions.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "compiler/evaluate/drawn_settings.h"
#include "compiler/evaluate/empirical.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/evaluate/positive_distributions.h"
#include "compiler/names/kind_name.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using Eigen::Vector3d;
using schema::DistributionKind;
using schema::Number;
using schema::Value;

/// The weight of a choice of any( ): 1 if none is given.
std::optional<double> WeightOf(const dsl::Argument& argument, const scenario::Scope& scope,
                               Evaluator& evaluator) {
  if (!argument.weight) return 1;
  const auto number = evaluator.EvaluateNumber(*argument.weight, scope, "weights");
  if (!number) return std::nullopt;
  if (!(number->AsReal() > 0))
    return evaluator.Error(scenario::kOutOfDomain, argument.weight->span,
                           "a weight must be greater than 0",
                           "remove choices that should never be drawn");
  return number->AsReal();
}

/// Adds a choice of any( ); false after a diagnostic.
bool AddChoice(const dsl::Argument& argument, const scenario::Scope& scope, Evaluator& evaluator,
               schema::Distribution& drawn) {
  if (argument.name) {
    evaluator.Error(scenario::kBadArguments, argument.name->span,
                    fmt::format("any() has no argument '{}'", argument.name->text),
                    "a weight follows its choice: any(sphere 3, cone 1)");
    return false;
  }
  const auto choice = evaluator.Evaluate(*argument.value, scope);
  const auto weight = WeightOf(argument, scope, evaluator);
  if (choice && AsDistribution(*choice)) {
    evaluator.Error(scenario::kBadArguments, argument.value->span,
                    "a distribution cannot be a choice of any( )");
    return false;
  }
  if (choice && AsFormula(*choice)) {
    RefuseFormula(*AsFormula(*choice), evaluator.diagnostics());
    return false;
  }
  if (!choice || !weight) return false;
  drawn.arguments.push_back(*choice);
  drawn.weights.push_back(*weight);
  return true;
}

/// A distribution of two numbers or two vectors while it is evaluated.
class PairDistribution {
 public:
  PairDistribution(const Expr& call, DistributionKind kind, const scenario::Scope& scope,
                   Evaluator& evaluator)
      : call_(call),
        kind_(kind),
        is_normal_(kind == DistributionKind::kNormal),
        usage_(is_normal_ ? "normal(mean, deviation), or normal(mean, variance: v)"
                          : "uniform(least, most)"),
        scope_(scope),
        evaluator_(evaluator) {}

  std::optional<Value> Evaluate() {
    for (const dsl::Argument& argument : call_.arguments)
      if (!CheckForm(argument) || !Add(argument)) return std::nullopt;
    if (!MatchKinds() || !CheckDomain()) return std::nullopt;
    if (is_variance_) arguments_[1] = DeviationOf(arguments_[1]);
    return schema::Distribution{kind_, std::move(arguments_), {}};
  }

 private:
  bool Fail(const dsl::DiagnosticKind& kind, const text::Span& span, std::string message,
            std::string help = {}) {
    evaluator_.Error(kind, span, std::move(message), std::move(help));
    return false;
  }

  bool CheckForm(const dsl::Argument& argument) {
    if (argument.weight)
      return Fail(scenario::kBadArguments, argument.weight->span,
                  fmt::format("{}() does not take weights", call_.text), usage_);
    if (!argument.name) return true;
    is_variance_ = argument.name->text == "variance";
    const bool is_second = arguments_.size() == 1;
    if (is_normal_ && is_second && (is_variance_ || argument.name->text == "sd")) return true;
    return Fail(scenario::kBadArguments, argument.name->span,
                fmt::format("{}() has no argument '{}'{}", call_.text, argument.name->text,
                            is_normal_ && !is_second ? " there" : ""),
                usage_);
  }

  bool Add(const dsl::Argument& argument) {
    const auto value = evaluator_.Evaluate(*argument.value, scope_);
    if (!value) return false;
    if (AsFormula(*value)) {
      RefuseFormula(*AsFormula(*value), evaluator_.diagnostics());
      return false;
    }
    if (!AsNumber(*value) && !AsVector(*value))
      return Fail(scenario::kWrongKind, argument.value->span,
                  fmt::format("{}() takes numbers or vectors, but this is {}", call_.text,
                              names::KindName(*value)),
                  usage_);
    arguments_.push_back(*value);
    return true;
  }

  /// Makes both numbers or both vectors: 0 beside a vector becomes a vector.
  bool MatchKinds() {
    if (arguments_.size() != 2)
      return Fail(scenario::kBadArguments, call_.span,
                  fmt::format("{}() takes two values, but there {} {}", call_.text,
                              arguments_.size() == 1 ? "is" : "are", arguments_.size()),
                  usage_);
    const auto widen = [](Value& value, const Value& other) {
      if (AsNumber(value) && AsVector(other) && AsNumber(value)->AsReal() == 0)
        value = Value(Vector3d(Vector3d::Zero()));
    };
    widen(arguments_[0], arguments_[1]);
    widen(arguments_[1], arguments_[0]);
    if ((AsVector(arguments_[0]) != nullptr) == (AsVector(arguments_[1]) != nullptr)) return true;
    return Fail(scenario::kBadArguments, call_.span, "one value is a number, the other a vector",
                "write both as numbers or both as vectors");
  }

  bool CheckDomain() {
    // Numbers become vectors of three equal components, so that one check serves both.
    const auto triple = [](const Value& value) {
      return AsVector(value) ? *AsVector(value)
                             : Vector3d(Vector3d::Constant(AsNumber(value)->AsReal()));
    };
    const Vector3d a = triple(arguments_[0]), b = triple(arguments_[1]);
    if (is_normal_ && (b.array() < 0).any())
      return Fail(
          scenario::kOutOfDomain, call_.arguments[1].value->span,
          fmt::format("a {} is 0 or more", is_variance_ ? "variance" : "standard deviation"));
    if (!is_normal_ && (a.array() > b.array()).any())
      return Fail(scenario::kOutOfDomain, call_.span,
                  fmt::format("the lower bound, {}, is greater than the upper, {}",
                              ToText(arguments_[0]), ToText(arguments_[1])),
                  "swap them");
    if (kind_ == DistributionKind::kLogUniform && (a.array() <= 0).any())
      return Fail(scenario::kOutOfDomain, call_.arguments[0].value->span,
                  "log_uniform() takes values greater than 0");
    return true;
  }

  static Value DeviationOf(const Value& variance) {
    if (AsVector(variance)) return Value(Vector3d(AsVector(variance)->array().sqrt()));
    return std::sqrt(AsNumber(variance)->AsReal());
  }

  const Expr& call_;
  const DistributionKind kind_;
  const bool is_normal_;
  const char* const usage_;
  const scenario::Scope& scope_;
  Evaluator& evaluator_;
  std::vector<Value> arguments_;
  bool is_variance_ = false;  ///< whether the second argument is a variance
};

/// Evaluates `in 2 .. 8`; nullopt after a diagnostic.
std::optional<schema::Limits> LimitsOf(const Expr& call, const scenario::Scope& scope,
                                       Evaluator& evaluator) {
  const auto least = evaluator.EvaluateNumber(*call.items[0], scope, "limits");
  const auto most = evaluator.EvaluateNumber(*call.items[1], scope, "limits");
  if (!least || !most) return std::nullopt;
  if (Compare(*least, *most) < 0) return schema::Limits{least->AsReal(), most->AsReal()};
  return evaluator.Error(scenario::kOutOfDomain, call.items[0]->span,
                         fmt::format("the lower limit, {}, is not less than the upper, {}",
                                     least->Text(), most->Text()));
}

}  // namespace

std::optional<Value> EvaluateAny(const Expr& call, const scenario::Scope& scope,
                                 Evaluator& evaluator) {
  if (call.arguments.empty())
    return evaluator.Error(scenario::kBadArguments, call.span, "any() has no choices");
  schema::Distribution drawn;
  drawn.kind = DistributionKind::kAny;
  bool good = true;
  for (const dsl::Argument& argument : call.arguments)
    good = AddChoice(argument, scope, evaluator, drawn) && good;
  if (!good) return std::nullopt;
  if (!call.items.empty())
    return evaluator.Error(scenario::kBadArguments, call.items[0]->span,
                           "any() draws from a list and cannot have limits",
                           "remove the values outside of them");
  return drawn;
}

std::optional<Value> EvaluateDistribution(const Expr& call, DistributionKind kind,
                                          const scenario::Scope& scope, Evaluator& evaluator) {
  using enum DistributionKind;
  std::optional<Value> drawn;
  if (kind == kAny) return EvaluateAny(call, scope, evaluator);
  if (kind == kEmpirical) {
    drawn = EvaluateEmpirical(call, evaluator);
  } else if (kind == kUniform || kind == kNormal || kind == kLogUniform) {
    drawn = PairDistribution(call, kind, scope, evaluator).Evaluate();
  } else {
    drawn = EvaluatePositive(call, kind, scope, evaluator);
  }
  if (!drawn || call.items.empty()) return drawn;
  const auto limits = LimitsOf(call, scope, evaluator);
  if (!limits) return std::nullopt;
  schema::Distribution limited = *AsDistribution(*drawn);
  limited.limits = limits;
  return limited;
}

}  // namespace cdb::evaluate
