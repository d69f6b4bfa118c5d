#include "compiler/evaluate/calls.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "compiler/analysis/model.h"
#include "compiler/analysis/soft.h"
#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/distributions.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/names/named_files.h"
#include "compiler/names/names.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using schema::Value;

/// `at((0, 0, 0), (1, 2, 3))`: the points, which must not have names or weights.
std::optional<Value> EvaluatePoints(const Expr& expr, const schema::ParametrisedWord& info,
                                    const scenario::Scope& scope, Evaluator& evaluator) {
  schema::Call call{std::string(info.name), {}};
  bool good = true;
  for (std::size_t i = 0; i < expr.arguments.size(); ++i) {
    const Expr& written = *expr.arguments[i].value;
    const auto value = evaluator.Evaluate(written, names::ArgumentScope(expr, i, scope));
    good = good && value && AsVector(*value);
    if (value && !AsVector(*value))
      evaluator.Error(scenario::kWrongKind, written.span,
                      fmt::format("this is {}, but the others are points", names::KindName(*value)),
                      "write (x, y, z) for each object");
    if (value) call.arguments.push_back(*value);
  }
  return good ? std::optional<Value>(std::move(call)) : std::nullopt;
}

/// Whether the arguments are points; nullopt if the first one is invalid.
std::optional<bool> HasPoints(const Expr& expr, const schema::ParametrisedWord& info,
                              const scenario::Scope& scope, Evaluator& evaluator) {
  const auto is_plain = [](const dsl::Argument& argument) {
    return !argument.name && !argument.weight;
  };
  if (!info.takes_points || expr.arguments.empty() ||
      !std::ranges::all_of(expr.arguments, is_plain))
    return false;
  const auto first =
      evaluator.Evaluate(*expr.arguments[0].value, names::ArgumentScope(expr, 0, scope));
  if (!first) return std::nullopt;
  return AsVector(*first) != nullptr;
}

/// Adds the number of nodes to a call of soft( ), unless its mesh cannot be read, which is reported
/// with the scene. False if another number is written.
bool StateNodes(const Expr& expr, schema::Call& call, Evaluator& evaluator) {
  const Value written = std::exchange(call.arguments.back(), schema::Word{"any"});
  analysis::ModelFault why;
  const auto model = evaluator.scenario().ModelAt(call, why);
  if (!model || model->tetrahedra == nullptr) return true;
  const std::uint64_t nodes = model->tetrahedra->NodeCount();
  call.arguments.back() = schema::Number(nodes);
  if (AsNumber(written) == nullptr || AsNumber(written)->AsCount() == nodes) return true;
  evaluator.Error(
      scenario::kContradiction, expr.span,
      fmt::format("its tetrahedra have {} nodes, not {}", nodes, AsNumber(written)->AsCount()),
      "remove the number; a plan states it");
  return false;
}

/// Evaluates a word with its arguments.
std::optional<Value> EvaluateWord(const Expr& expr, const schema::ParametrisedWord& info,
                                  const scenario::Scope& scope, Evaluator& evaluator) {
  const auto has_points = HasPoints(expr, info, scope, evaluator);
  if (!has_points) return std::nullopt;
  if (*has_points) return EvaluatePoints(expr, info, scope, evaluator);
  auto call = EvaluateArguments(expr, info, scope, evaluator);
  if (!call) return std::nullopt;
  if (schema::NamesFile(info) &&
      !names::ReadNamedFile(evaluator.scenario(), *call, evaluator.diagnostics()))
    return std::nullopt;
  if (info.name == schema::kSoftCall && !StateNodes(expr, *call, evaluator)) return std::nullopt;
  return *std::move(call);
}

/// The sweep for a function of Python or NumPy that lists numbers; empty for others.
std::string InsteadOfRange(const Expr& expr) {
  const auto written = [&](std::size_t i) { return text::TextOf(expr.arguments[i].value->span); };
  const std::size_t count = expr.arguments.size();
  const bool is_by_step = expr.text == "range" || expr.text == "arange";
  const bool is_log = expr.text == "geomspace";
  if (is_by_step && count == 3)
    return fmt::format("sweep({} .. {} step {})", written(0), written(1), written(2));
  if (is_by_step && count == 2) return fmt::format("sweep({} .. {})", written(0), written(1));
  if ((is_log || expr.text == "linspace") && count == 3)
    return fmt::format("sweep({} .. {} count {}{})", written(0), written(1), written(2),
                       is_log ? " log" : "");
  if (expr.text == "logspace" && count == 3)
    return fmt::format("sweep(10 ^ {} .. 10 ^ {} count {} log)", written(0), written(1),
                       written(2));
  return {};
}

std::nullopt_t NoSuchFunction(const Expr& expr, const scenario::Scope& scope,
                              Evaluator& evaluator) {
  const auto takes_word = [&](const schema::Parameter& parameter) {
    return parameter.HasWord(expr.text, evaluator.scenario().plugins());
  };
  const names::Referent referent = evaluator.names().Resolve(expr.text, scope);
  if (!referent.IsWord() ||
      (scope.parameter != nullptr ? takes_word(*scope.parameter)
                                  : std::ranges::any_of(schema::Schema(), takes_word)))
    return evaluator.Error(scenario::kBadArguments, expr.span,
                           fmt::format("'{}' takes no arguments", expr.text),
                           fmt::format("write {} alone", expr.text));
  if (const std::string range = InsteadOfRange(expr); !range.empty())
    return evaluator.Error(scenario::kUnknownName, expr.span,
                           fmt::format("no function is called '{}'", expr.text),
                           fmt::format("write {}", range));
  std::vector<std::string_view> names = schema::DistributionNames();
  names.insert(names.begin(), {kSweep, kFind, kRace});
  const std::vector<std::string_view> functions = FunctionNames();
  names.insert(names.end(), functions.begin(), functions.end());
  for (const schema::ParametrisedWord& info : schema::ParametrisedWords())
    if (scope.parameter == nullptr || scope.parameter->TakesCall(info.name))
      names.push_back(info.name);
  std::string_view near = dsl::DidYouMean(expr.text, names);
  if (std::ranges::find(names, schema::WordFor(expr.text)) != names.end())
    near = schema::WordFor(expr.text);
  if (expr.text == "zip")
    return evaluator.Error(scenario::kMisplacedSweep, expr.span,
                           "zip() has several values, and is only allowed in a let",
                           "write: let a, b = zip(sweep(1, 2), sweep(10, 20)), and use a and b");
  if (expr.text == "until")
    return evaluator.Error(scenario::kUnknownName, expr.span,
                           "the number of repeats cannot depend on a measurement",
                           "write the upper limit, such as repeats 50; `cdb run --until 1%` stops "
                           "once every interval is within 1 %");
  return evaluator.Error(scenario::kUnknownName, expr.span,
                         fmt::format("no function is called '{}'", expr.text),
                         near.empty() ? fmt::format("there are {}", fmt::join(names, ", "))
                                      : fmt::format("did you mean '{}'?", near));
}

/// Adds the parts of the list to the call, which has its arguments.
bool EvaluateParts(const Expr& expr, const schema::ParametrisedWord& info,
                   const scenario::Scope& scope, Evaluator& evaluator, schema::Call& call) {
  const schema::Parameter& parameter = schema::PartParameter();
  scenario::Scope inner = scope;
  inner.parameter = &parameter;
  bool good = true, has_part = false;
  for (const dsl::Argument& argument : expr.arguments) {
    if (argument.name) continue;
    has_part = true;
    auto value = evaluator.Evaluate(*argument.value, inner);
    if (value) value = evaluator.ConvertFor(parameter, *value, *argument.value, inner);
    good = good && value;
    if (value) call.arguments.push_back(*value);
  }
  if (!has_part)
    evaluator.Error(scenario::kBadArguments, expr.span, fmt::format("'{}' needs a part", info.name),
                    "write compound(part(cuboid, (1, 2, 3))), for example");
  return good && has_part;
}

}  // namespace

std::optional<schema::Call> EvaluateArguments(const Expr& expr,
                                              const schema::ParametrisedWord& info,
                                              const scenario::Scope& scope, Evaluator& evaluator) {
  const names::GivenArguments given(expr, info, evaluator.diagnostics());
  bool good = given.good();
  schema::Call call{std::string(info.name), {}};
  std::vector<std::string_view> missing;
  for (std::size_t i = 0; i < info.arguments.size(); ++i) {
    const schema::Parameter& parameter = info.arguments[i];
    if (given[i] == nullptr) {
      if (parameter.DefaultText().empty()) {
        missing.push_back(parameter.name);
      } else {
        call.arguments.push_back(schema::DefaultOf(parameter));
      }
      continue;
    }
    scenario::Scope inner = scope;
    inner.parameter = &parameter;
    const Expr& written = *given[i]->value;
    auto value = evaluator.Evaluate(written, inner);
    if (value) value = evaluator.ConvertFor(parameter, *value, written, inner);
    good = good && value;
    if (value) call.arguments.push_back(*value);
  }
  if (info.takes_parts) good = EvaluateParts(expr, info, scope, evaluator, call) && good;
  // A misspelt name explains a missing argument.
  if (given.good() && !missing.empty())
    ReportMissingArguments(info, missing, expr.span, evaluator.diagnostics());
  if (!good || !missing.empty()) return std::nullopt;
  return call;
}

std::optional<Value> EvaluateCall(const Expr& call, const scenario::Scope& scope,
                                  Evaluator& evaluator) {
  if (!call.items.empty() && !schema::FindDistribution(call.text))
    return evaluator.Error(scenario::kBadArguments, call.span,
                           fmt::format("{}() cannot have limits", call.text),
                           "'in a .. b' limits a distribution");
  if (IsSweep(call)) return evaluator.sweeps().Evaluate(call, scope);
  if (call.axis)
    return evaluator.Error(scenario::kMisplacedSweep, call.axis->span,
                           "only a sweep makes an axis, which can have a name");
  if (IsFunction(call.text)) return EvaluateFunction(call, scope, evaluator);
  if (call.text == "any") return EvaluateAny(call, scope, evaluator);
  if (const auto kind = schema::FindDistribution(call.text))
    return EvaluateDistribution(call, *kind, scope, evaluator);
  if (const schema::ParametrisedWord* info = schema::FindParametrisedWord(call.text))
    return EvaluateWord(call, *info, scope, evaluator);
  return NoSuchFunction(call, scope, evaluator);
}

}  // namespace cdb::evaluate
