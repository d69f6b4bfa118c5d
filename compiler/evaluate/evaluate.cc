#include "compiler/evaluate/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/defaults.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using dsl::ExprKind;

constexpr std::size_t kMaxChain = 500;

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

Evaluator::Evaluator(const scenario::Scenario& scenario, const scenario::Layers& layers,
                     dsl::Diagnostics& diagnostics)
    : scenario_(scenario), layers_(layers), diagnostics_(diagnostics) {}

std::nullopt_t Evaluator::Error(const dsl::DiagnosticKind& kind, const dsl::Span& span,
                                std::string message, std::string help) {
  diagnostics_.Report(kind, span, std::move(message), std::move(help));
  return std::nullopt;
}

void Evaluator::Choose(const Expr& call, std::size_t index) {
  std::size_t& chosen = chosen_[&call];
  if (chosen == index) return;
  chosen = index;
  let_values_.clear();
}

std::optional<Term> Evaluator::Evaluate(const Expr& expr, const scenario::Scope& scope) {
  std::optional<Term> term;
  switch (expr.kind) {
    case ExprKind::kNumber: {
      const auto number = Number::FromLiteral(expr.text);
      if (!number)
        return Error(scenario::kNotFinite, expr.span,
                     fmt::format("'{}' does not fit into 64 bits", expr.text));
      term = Term{*number};
      break;
    }
    case ExprKind::kText:
      return Term{schema::Text{expr.text}, expr.span};
    case ExprKind::kPath:
      return EvaluatePath(expr, scope);
    case ExprKind::kVector: {
      if (scope.parameter != nullptr && scope.parameter->type == schema::ParameterType::kWords)
        return Error(
            scenario::kWrongKind, expr.span,
            fmt::format("'{}' takes words, and no brackets around them", scope.parameter->name),
            "cases { } are an axis whose values are lists");
      if (expr.items.size() != 3) return std::nullopt;  // as the parser has said
      const auto vector = EvaluateTriple(expr, scope, "a vector's components");
      if (!vector) return std::nullopt;
      term = Term{*vector};
      break;
    }
    case ExprKind::kRatio: {
      const auto parts = EvaluateTriple(expr, scope, "a ratio's parts");
      if (!parts) return std::nullopt;
      term = Term{schema::Ratio{*parts}};
      break;
    }
    case ExprKind::kCall:
      return EvaluateCall(expr, scope);
    case ExprKind::kNegate: {
      const auto operand = Evaluate(*expr.items[0], scope);
      if (!operand) return std::nullopt;
      if (operand->number()) {
        term = Term{-*operand->number()};
      } else if (operand->vector()) {
        term = Term{Eigen::Vector3d(-*operand->vector())};
      } else {
        return Error(scenario::kWrongKind, expr.span,
                     fmt::format("{} cannot be negated", KindName(*operand)));
      }
      break;
    }
    case ExprKind::kBinary:
      term = EvaluateBinary(expr, scope);
      if (!term) return std::nullopt;
      break;
    case ExprKind::kRange:
      return Error(scenario::kMisplacedRange, expr.span, "a range is not a value",
                   "sweep(…) around it makes one run for each of its values");
  }
  if (!Finite(*term, expr.span)) return std::nullopt;
  return term;
}

std::nullopt_t Evaluator::NoSuchLet(const dsl::Span& span, const std::string& word,
                                    const scenario::Scope& scope) {
  std::vector<std::string_view> names;
  if (scope.file != nullptr) names = scenario_.LetNames(*scope.file);
  for (const auto& [key, let] : layers_.lets) names.push_back(key.second);
  const std::string_view near = dsl::DidYouMean(word, names);
  return Error(scenario::kUnknownName, span, fmt::format("no let is called '{}'", word),
               near.empty() ? "" : fmt::format("did you mean '{}'?", near));
}

bool Evaluator::Finite(const Term& term, const dsl::Span& span) {
  const bool finite = term.number()   ? std::isfinite(term.number()->AsReal())
                      : term.vector() ? term.vector()->allFinite()
                                      : true;
  if (!finite) Error(scenario::kNotFinite, span, "this is not a finite number");
  return finite;
}

std::optional<Number> Evaluator::EvaluateNumber(const Expr& expr, const scenario::Scope& scope,
                                                const char* what) {
  const auto term = Evaluate(expr, scope);
  if (!term) return std::nullopt;
  if (!term->number())
    return Error(scenario::kWrongKind, expr.span,
                 fmt::format("{} are numbers, this is {}", what, KindName(*term)),
                 term->drawn()
                     ? "put the vectors into the distribution: uniform((0, 0, 0), (1, 2, 3))"
                     : "");
  return *term->number();
}

std::optional<Eigen::Vector3d> Evaluator::EvaluateTriple(const Expr& expr,
                                                         const scenario::Scope& scope,
                                                         const char* what) {
  Eigen::Vector3d triple;
  for (int i = 0; i < 3; ++i) {
    const auto number = EvaluateNumber(*expr.items[static_cast<std::size_t>(i)], scope, what);
    if (!number) return std::nullopt;
    triple[i] = number->AsReal();
  }
  return triple;
}

Referent Evaluator::Resolve(const std::string& path, const scenario::Scope& scope) const {
  if (scope.file == nullptr) return {};  // a default of the schema: its words are words
  if (scope.parameter != nullptr &&
      (scope.parameter->HasWord(path, scenario_.plugins()) || scope.parameter->TakesCall(path)))
    return {};
  for (std::string block = scenario::Joined(scope.group, scope.block);;
       block = scenario::Outside(block)) {
    const auto let = layers_.lets.find({block, path});
    if (let != layers_.lets.end()) return {let->second, std::nullopt};
    if (block.empty()) break;
  }
  if (scope.file != nullptr) {
    if (const auto let = scenario_.FindLet(*scope.file, path)) {
      Referent referent;
      referent.let.emplace();
      referent.let->node = let->let;
      referent.let->scope.file = let->file;
      referent.let->order = -1'000'000 + scenario_.LetOrder(*let->let);
      return referent;
    }
  }
  const auto is_group = [&](const std::string& name) {
    return std::ranges::find(layers_.groups, name) != layers_.groups.end();
  };
  for (std::string block = scope.block;; block = scenario::Outside(block)) {
    if (const schema::Parameter* parameter =
            schema::FindParameter(scenario::Joined(block, path), !scope.group.empty()))
      return {std::nullopt, scenario::ParameterKey{scope.group, parameter}};
    if (block.empty()) break;
  }
  if (const schema::Parameter* parameter = schema::FindParameter(path, false))
    return {std::nullopt, scenario::ParameterKey{"", parameter}};
  // Outside the blocks `quantity` is that of the objects, as the axis is called.
  if (scope.group.empty() && scope.block.empty() && is_group("objects"))
    if (const schema::Parameter* parameter = schema::FindParameter(path, true))
      return {std::nullopt, scenario::ParameterKey{"objects", parameter}};
  const std::size_t dot = path.find('.');
  if (dot != std::string::npos && is_group(path.substr(0, dot)))
    if (const schema::Parameter* parameter = schema::FindParameter(path.substr(dot + 1), true))
      return {std::nullopt, scenario::ParameterKey{path.substr(0, dot), parameter}};
  return {};
}

std::nullopt_t Evaluator::Circle(const void* node) {
  // Said of the same one, wherever the circle was entered.
  const auto begin = std::ranges::find(active_, node, &Active::node);
  const auto first = std::min_element(begin, active_.end(), [](const Active& a, const Active& b) {
    return a.name.span.begin < b.name.span.begin;
  });
  return Error(scenario::kCircular, first->name.span,
               fmt::format("'{}' leads back to itself", first->name.text));
}

std::optional<Term> Evaluator::EvaluatePath(const Expr& expr, const scenario::Scope& scope) {
  const Referent referent = Resolve(expr.text, scope);
  if (!referent.let && !referent.parameter) {
    if (expr.text.find('.') != std::string::npos)
      return Error(scenario::kUnknownName, expr.span,
                   fmt::format("nothing is called '{}'", expr.text));
    return Term{schema::Word{expr.text}};
  }
  const void* node = referent.let ? static_cast<const void*>(referent.let->node)
                                  : static_cast<const void*>(referent.parameter->second);
  if (std::ranges::find(active_, node, &Active::node) != active_.end()) return Circle(node);
  if (active_.size() >= kMaxChain)
    return Error(scenario::kCircular, expr.span, fmt::format("'{}' leads on and on", expr.text),
                 fmt::format("lets may use one another {} deep", kMaxChain));
  dsl::Name name{expr.text, expr.span};
  if (referent.let) {
    name = referent.let->node->name;
  } else if (const auto set = layers_.settings.find(*referent.parameter);
             set != layers_.settings.end()) {
    name = set->second.node->path;
  }
  std::optional<Term> term;
  if (referent.let) {
    const auto known = let_values_.find(referent.let->node);
    if (known != let_values_.end()) return known->second;
    active_.push_back({node, name});
    term = Evaluate(*referent.let->node->value, referent.let->scope);
    active_.pop_back();
    let_values_[referent.let->node] = term;
  } else {
    active_.push_back({node, name});
    term = EvaluateParameter(*referent.parameter);
    active_.pop_back();
    if (term && term->drawn())
      return Error(
          scenario::kWrongKind, expr.span,
          fmt::format("'{}' is drawn anew for each object and has no one value", expr.text));
  }
  return term;
}

std::optional<Term> Evaluator::EvaluateParameter(const scenario::ParameterKey& key) {
  const auto set = layers_.settings.find(key);
  if (key.second->type == schema::ParameterType::kWords)
    return set != layers_.settings.end() ? EvaluateList(*set->second.node, set->second.scope)
                                         : EvaluateList(DefaultSetting(*key.second), {});
  if (set != layers_.settings.end() && set->second.node->values.size() == 1)
    return Evaluate(*set->second.node->values[0], set->second.scope);
  if (key.second->name == "world.side" && set == layers_.settings.end()) {
    Number objects = Number::Whole(0);
    for (const std::string& group : layers_.groups) {
      const auto quantity = EvaluateParameter({group, schema::GroupParameter("quantity").get()});
      if (!quantity || !quantity->number()) return std::nullopt;
      objects = objects + *quantity->number();
    }
    // An empty world still has a cube.
    if (objects.AsReal() < 1) objects = Number::Whole(1);
    return Term{Number::Whole(50) * objects};
  }
  return Evaluate(*DefaultSetting(*key.second).values[0], {});
}

const Expr& Evaluator::Origin(const Expr& expr, const scenario::Scope& scope) {
  if (expr.kind != ExprKind::kCall || expr.text != "sweep") return expr;
  const Sweep* sweep = FindSweep(expr, scope);
  if (sweep == nullptr) return expr;
  const Expr* item = sweep->items[chosen_[&expr]].expr;
  return item != nullptr ? *item : expr;
}

std::optional<schema::Value> Evaluator::ToValue(const Term& term,
                                                const schema::Parameter& parameter,
                                                const Expr& expr, const scenario::Scope& scope) {
  if (term.text() != nullptr && parameter.TakesCall(schema::kTraceCall)) return TraceNamed(term);
  const Expr& origin = Origin(expr, scope);
  std::vector<dsl::Span> choices;
  if (origin.kind == ExprKind::kCall)
    for (const dsl::Argument& argument : origin.arguments) choices.push_back(argument.value->span);
  return Convert(term, parameter, origin.span, choices, scenario_.plugins(), diagnostics_);
}

std::optional<Term> Evaluator::EvaluateList(const dsl::Setting& setting,
                                            const scenario::Scope& scope) {
  if (setting.values.size() == 1) return Evaluate(*setting.values[0], scope);
  schema::WordList words;
  for (const auto& value : setting.values) {
    const auto term = Evaluate(*value, scope);
    if (!term) return std::nullopt;
    words.push_back(ToText(*term));
  }
  std::ranges::sort(words);
  return Term{schema::Word{ToText(schema::Value(std::move(words)))}};
}

std::optional<Term> Evaluator::EvaluateBinary(const Expr& expr, const scenario::Scope& scope) {
  const auto left = Evaluate(*expr.items[0], scope);
  const auto right = Evaluate(*expr.items[1], scope);
  if (!left || !right) return std::nullopt;
  if (left->number() && right->number()) {
    const Number &a = *left->number(), &b = *right->number();
    switch (expr.op) {
      case '+':
        return Term{a + b};
      case '-':
        return Term{a - b};
      case '*':
        return Term{a * b};
      case '/':
        if (b.AsReal() == 0)
          return Error(scenario::kNotFinite, expr.items[1]->span, "division by zero");
        return Term{a / b};
      default:
        return Term{Power(a, b)};
    }
  }
  if (left->vector() && right->vector() && (expr.op == '+' || expr.op == '-')) {
    const double sign = expr.op == '+' ? 1 : -1;
    return Term{Eigen::Vector3d(*left->vector() + sign * *right->vector())};
  }
  if (left->number() && right->vector() && expr.op == '*')
    return Term{Eigen::Vector3d(left->number()->AsReal() * *right->vector())};
  if (left->vector() && right->number() && (expr.op == '*' || expr.op == '/')) {
    const double factor = right->number()->AsReal();
    if (expr.op == '*') return Term{Eigen::Vector3d(*left->vector() * factor)};
    if (factor == 0) return Error(scenario::kNotFinite, expr.items[1]->span, "division by zero");
    return Term{Eigen::Vector3d(*left->vector() / factor)};
  }
  for (const int side : {0, 1}) {
    const Term& term = side == 0 ? *left : *right;
    const dsl::Span& span = expr.items[static_cast<std::size_t>(side)]->span;
    if (term.word()) return NoSuchLet(span, term.word()->text, scope);
    if (!term.number() && !term.vector())
      return Error(scenario::kWrongKind, span,
                   fmt::format("cannot calculate with {}", KindName(term)));
  }
  return Error(scenario::kWrongKind, expr.span,
               fmt::format("'{}' does not go between {} and {}", expr.op, KindName(*left),
                           KindName(*right)));
}

std::optional<Term> Evaluator::EvaluateCall(const Expr& expr, const scenario::Scope& scope) {
  if (expr.text == "sweep") {
    if (in_sweep_)
      return Error(scenario::kMisplacedSweep, expr.span, "a sweep cannot stand inside a sweep");
    const Sweep* sweep = FindSweep(expr, scope);
    if (sweep == nullptr) return std::nullopt;
    const Sweep::Item& item = sweep->items[chosen_[&expr]];
    if (item.number) return Term{*item.number};
    const Restore guard(in_sweep_, true);
    return Evaluate(*item.expr, scope);
  }
  if (expr.axis)
    return Error(scenario::kMisplacedSweep, expr.axis->span,
                 "only a sweep makes an axis that has a name");
  if (expr.text == "any") return EvaluateAny(expr, scope);
  if (const auto kind = schema::FindDistribution(expr.text))
    return EvaluateDrawn(expr, *kind, scope);
  if (const schema::ParametrisedWord* info = schema::FindParametrisedWord(expr.text))
    return EvaluateWord(expr, *info, scope);
  return NoSuchFunction(expr, scope);
}

const Sweep* Evaluator::FindSweep(const Expr& call, const scenario::Scope& scope) {
  const auto known = sweeps_.find(&call);
  if (known != sweeps_.end()) return known->second ? &*known->second : nullptr;
  auto& sweep = sweeps_[&call];
  Sweep made{&call, scope, {}};
  const Restore guard(in_sweep_, true);
  bool good = true;
  for (const dsl::Argument& argument : call.arguments) {
    if (argument.name || argument.weight) {
      Error(scenario::kBadArguments, argument.name ? argument.name->span : argument.weight->span,
            argument.name ? fmt::format("sweep( ) has no argument '{}'", argument.name->text)
                          : "sweep( ) takes no weights",
            argument.name ? "sweep(1, 2, 5) or sweep(1 .. 5)" : "separate the values by commas");
      good = false;
    } else {
      good = AddItems(*argument.value, scope, made.items) && good;
    }
  }
  if (good && made.items.empty()) {
    Error(scenario::kBadArguments, call.span, "sweep( ) has no value",
          "sweep(1, 2, 5) or sweep(1 .. 5)");
    good = false;
  }
  if (good) sweep = std::move(made);
  return sweep ? &*sweep : nullptr;
}

bool Evaluator::AddItems(const Expr& expr, const scenario::Scope& scope,
                         std::vector<Sweep::Item>& items) {
  if (expr.kind == ExprKind::kRange) return ExpandRange(expr, scope, items);
  if (expr.kind == ExprKind::kPath) {
    // A let may hold a range.
    const Referent referent = Resolve(expr.text, scope);
    if (referent.let && referent.let->node->value->kind == ExprKind::kRange)
      return ExpandRange(*referent.let->node->value, referent.let->scope, items);
  }
  items.push_back({&expr, std::nullopt});
  // Reported here, since a value that is no good at all may never be chosen.
  return Evaluate(expr, scope).has_value();
}

bool Evaluator::ExpandRange(const Expr& range, const scenario::Scope& scope,
                            std::vector<Sweep::Item>& items) {
  std::vector<Number> bounds;
  for (const auto& item : range.items) {
    const auto number = EvaluateNumber(*item, scope, "a range's bounds");
    if (!number) return false;
    bounds.push_back(*number);
  }
  const Number &first = bounds[0], &last = bounds[1];
  const auto add = [&](const Number& number) { items.push_back({nullptr, number}); };
  const auto too_many = [&](double count) {
    Error(scenario::kTooManyRuns, range.span, fmt::format("this range has {:.6g} values", count),
          fmt::format("an axis has at most {}", kMaxRuns));
    return false;
  };
  using enum dsl::RangeKind;
  if (range.range == kCount || range.range == kCountLog) {
    const auto count = bounds[2].AsWhole();
    if (!count || *count < 1) {
      Error(scenario::kBadRange, range.items[2]->span, "a count is a whole number, 1 or more");
      return false;
    }
    if (*count > static_cast<Integer>(kMaxRuns)) return too_many(bounds[2].AsReal());
    const auto n = static_cast<std::size_t>(*count);
    const bool log = range.range == kCountLog;
    if (log && (first.AsReal() <= 0 || last.AsReal() <= 0)) {
      Error(scenario::kBadRange, range.span, "a logarithmic range lies above 0");
      return false;
    }
    for (std::size_t i = 0; i < n; ++i) {
      // The ends are what was written; between them no error adds up.
      if (i == 0 || i + 1 == n) {
        add(i == 0 ? first : last);
        continue;
      }
      const double part = static_cast<double>(i) / static_cast<double>(n - 1);
      if (log) {
        // In decades, so that 1 .. 1000 count 4 gives 10 and 100 as they are.
        const double low = std::log10(first.AsReal()), high = std::log10(last.AsReal());
        add(Number::Real(std::pow(10.0, low + part * (high - low))));
      } else {
        add(first + (last - first) * Number::Whole(static_cast<Integer>(i)) /
                        Number::Whole(static_cast<Integer>(n - 1)));
      }
    }
    return true;
  }
  const Number step = range.range == kStep ? bounds[2] : Number::Whole(1);
  const double way = (last - first).AsReal();
  if (step.AsReal() == 0) {
    Error(scenario::kBadRange, range.items[2]->span, "a range with step 0 never ends");
    return false;
  }
  const double steps = way / step.AsReal();
  if (steps < 0) {
    Error(scenario::kBadRange, range.span,
          fmt::format("this range is empty: from {} steps of {} never come to {}", first.Text(),
                      step.Text(), last.Text()),
          range.range == kStep ? "turn the step's sign" : "to count down add: step -1");
    return false;
  }
  // A step like 0.1 is not quite a tenth: the end counts as hit within a billionth of a step.
  const double count = std::floor(steps + 1e-9) + 1;
  if (!(count <= static_cast<double>(kMaxRuns))) return too_many(count);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const bool at_end = std::fabs(static_cast<double>(i) - steps) <= 1e-9;
    add(at_end ? last : first + step * Number::Whole(static_cast<Integer>(i)));
  }
  return true;
}

std::vector<std::string_view> Evaluator::WordsOf(const Expr& expr,
                                                 const scenario::Scope& scope) const {
  if (expr.kind != ExprKind::kPath) return {};
  if (const auto axis = axis_words.find(expr.text); axis != axis_words.end())
    return {axis->second.begin(), axis->second.end()};
  if (axis_values.contains(expr.text)) return {};
  const Referent referent = Resolve(expr.text, scope);
  if (!referent.parameter) return {};
  const schema::Parameter& parameter = *referent.parameter->second;
  std::vector<std::string_view> words = parameter.AllWords(scenario_.plugins());
  for (const std::string_view call : parameter.AllCalls()) words.push_back(call);
  return words;
}

std::optional<Term> Evaluator::Comparand(const Expr& expr, const Expr& other,
                                         const scenario::Scope& scope) {
  if (expr.kind == ExprKind::kPath) {
    // Beside `omit`, `sleeping` is a component and not the switch of that name.
    const auto words = WordsOf(other, scope);
    if (std::ranges::find(words, expr.text) != words.end() && !Resolve(expr.text, scope).let)
      return Term{schema::Word{expr.text}};
    const auto axis = axis_values.find(expr.text);
    if (axis != axis_values.end()) return axis->second;
  }
  return Evaluate(expr, scope);
}

bool Evaluator::IsLiteralWord(const Expr& expr, const scenario::Scope& scope) const {
  if (expr.kind != ExprKind::kPath || axis_values.contains(expr.text)) return false;
  const Referent referent = Resolve(expr.text, scope);
  return !referent.let && !referent.parameter;
}

bool Evaluator::CheckWord(const Expr& word, const Expr& other, const scenario::Scope& scope) {
  const std::vector<std::string_view> words = WordsOf(other, scope);
  if (other.kind == ExprKind::kPath && !axis_values.contains(other.text) &&
      Resolve(other.text, scope).let)
    return true;
  if (std::ranges::find(words, word.text) != words.end()) return true;
  const std::string_view near = dsl::DidYouMean(word.text, words);
  Error(scenario::kUnknownName, word.span,
        words.empty() ? fmt::format("no axis, let or parameter is called '{}'", word.text)
                      : fmt::format("'{}' is never '{}'", other.text, word.text),
        near.empty() ? (words.empty() ? "" : fmt::format("it is one of {}", fmt::join(words, ", ")))
                     : fmt::format("did you mean '{}'?", near));
  return false;
}

bool Evaluator::Holds(const dsl::Condition& condition, const scenario::Scope& scope) {
  using enum dsl::ConditionKind;
  // Both sides are always evaluated, so that every error is found.
  switch (condition.kind) {
    case kNot:
      return !Holds(*condition.items[0], scope);
    case kAnd:
    case kOr: {
      const bool left = Holds(*condition.items[0], scope);
      const bool right = Holds(*condition.items[1], scope);
      return condition.kind == kAnd ? left && right : left || right;
    }
    case kCompare:
      break;
  }
  for (const bool swap : {false, true}) {
    const Expr& word = swap ? *condition.left : *condition.right;
    const Expr& other = swap ? *condition.right : *condition.left;
    if (IsLiteralWord(word, scope) && !CheckWord(word, other, scope)) return false;
  }
  const auto left = Comparand(*condition.left, *condition.right, scope);
  const auto right = Comparand(*condition.right, *condition.left, scope);
  if (!left || !right) return false;
  const std::string& op = condition.op;
  if (left->number() && right->number()) {
    const auto order = Compare(*left->number(), *right->number());
    if (op == "==") return order == 0;
    if (op == "!=") return order != 0;
    if (op == "<") return order < 0;
    if (op == "<=") return order <= 0;
    if (op == ">") return order > 0;
    return order >= 0;
  }
  if (op != "==" && op != "!=") {
    Error(scenario::kBadComparison, condition.span, fmt::format("'{}' compares numbers only", op),
          "words are compared with == and !=");
    return false;
  }
  bool equal = false;
  if (left->vector() && right->vector()) {
    equal = *left->vector() == *right->vector();
  } else if (left->number() == nullptr && right->number() == nullptr) {
    equal = ToText(*left) == ToText(*right);
  }
  return (op == "==") == equal;
}

}  // namespace cdb::evaluate
