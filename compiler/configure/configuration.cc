#include "compiler/configure/configuration.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "compiler/analysis/configurations.h"
#include "compiler/configure/axes.h"
#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/dimensions.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/names/names.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "dsl/text/check.h"

namespace cdb::configure {
namespace {

using dsl::ExprKind;
using schema::Value;

/// The value, for the argument that axis `like` sweeps, in a value that is not swept here; nullopt
/// if the value is another word.
std::optional<Value> ArgumentLike(const SweepAxis& like, const Value& value) {
  std::optional<schema::Call> call;
  if (AsCall(value)) call = *AsCall(value);
  if (AsWord(value) && AsWord(value)->text == like.word->name)
    call = schema::WithDefaults(*like.word);
  if (!call || call->name != like.word->name || ListsPoints(*call)) return std::nullopt;
  return schema::ArgumentOf(*call, like.argument->name);
}

bool IsDrawn(const Value& value) {
  const auto* word = std::get_if<schema::Word>(&value);
  const schema::Call* call = schema::AsCall(value);
  return std::holds_alternative<schema::Distribution>(value) || (word && word->text == "random") ||
         (call && std::ranges::any_of(call->arguments, IsDrawn));
}

void AddSeeds(plan::Scene& scene) {
  const std::uint64_t seed = scene.world.Count("seed");
  const auto add = [&](const std::string& stream) {
    scene.seeds.emplace(stream, plan::StreamSeed(seed, stream));
  };
  for (const auto& [name, value] : scene.world)
    if (IsDrawn(value)) add(std::string(name));
  for (const plan::Group& group : scene.groups) {
    add(group.name + ".location");
    for (const auto& [name, value] : group.settings)
      if (IsDrawn(value)) add(fmt::format("{}.{}", group.name, name));
  }
  // Their defaults are drawn, too.
  for (const plan::Queries& queries : scene.queries)
    for (const schema::Parameter& parameter : schema::Schema())
      if (parameter.NamedBlock() == schema::kQueriesBlock &&
          IsDrawn(queries.settings.ValueOf(parameter)))
        add(fmt::format("{}.{}", queries.name, parameter.OwnName()));
  if (scene.world.WordOr("configurations.positions") == "uniform")
    for (const plan::Joint& joint : scene.joints) add(joint.name + analysis::kPositionStream);
}

}  // namespace

bool Advance(Point& point, const std::vector<std::size_t>& extents) {
  for (std::size_t i = extents.size(); i-- > 0;) {
    if (++point[i] < extents[i]) return true;
    point[i] = 0;
  }
  return false;
}

Configuration::Configuration(const scenario::Scenario& scenario, scenario::Layers layers,
                             dsl::Diagnostics& diagnostics)
    : scenario_(scenario),
      layers_(std::move(layers)),
      evaluator_(scenario, layers_, diagnostics),
      conditions_(evaluator_),
      axes_(FindAxes(layers_, evaluator_)) {
  // Unused lets are checked too.
  for (const auto& [key, let] : layers_.lets)
    if (let.node->value->kind != ExprKind::kRange) evaluator_.Evaluate(*let.node->value, let.scope);
  const int before = diagnostics.error_count();
  faulty_ = evaluate::Dimensions(layers_, evaluator_).CheckAll();
  unit_errors_ = diagnostics.error_count() - before;
  std::vector<scenario::ParameterKey> keys;
  for (const schema::Parameter& parameter : schema::Schema()) {
    if (!parameter.grouped) {
      keys.emplace_back("", &parameter);
      continue;
    }
    for (const std::string& group : layers_.NamesOf(parameter.NamedBlock()))
      keys.emplace_back(group, &parameter);
  }
  std::vector<std::vector<std::size_t>> axes = Dependencies(keys, layers_, axes_, evaluator_);
  for (std::size_t i = 0; i < keys.size(); ++i)
    parameters_.push_back({std::move(keys[i]), std::move(axes[i])});
}

void Configuration::Choose(const Point& point) {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    if (point_.empty() || point_[i] != point[i]) evaluator_.Choose(*axes_[i].call, point[i]);
  point_ = point;
}

void Configuration::Complete(plan::Scene& scene) const {
  scene.seeds.clear();
  AddSeeds(scene);
  scene.plugins.assign(scenario_.plugins().begin(), scenario_.plugins().end());
  scene.KeepUsedPlugins();
}

void Configuration::CheckSettings() {
  Choose(Point(axes_.size(), 0));
  for (const DependentParameter& parameter : parameters_) ReportAll(parameter);
  for (const auto& skip : layers_.skips)
    if (skip.node->when) conditions_.CheckCalls(*skip.node->when);
}

text::Span Configuration::SpanOf(const scenario::ParameterKey& key, const text::Span& otherwise) {
  const auto setting = layers_.settings.find(key);
  if (setting == layers_.settings.end()) return otherwise;
  return evaluator_.sweeps().Origin(*setting->second.node->values[0], setting->second.scope).span;
}

text::Span Configuration::SpanOfWord(const scenario::ParameterKey& key, std::string_view word) {
  const scenario::Placed<dsl::Setting>& setting = layers_.settings.at(key);
  for (const auto& value : setting.node->values) {
    const auto item = evaluator_.Evaluate(*value, setting.scope);
    if (item && AsWord(*item) && AsWord(*item)->text == word)
      return evaluator_.sweeps().Origin(*value, setting.scope).span;
  }
  CDB_CHECK(false);
}

std::optional<Value> Configuration::ConstantFor(const SweepAxis& like) {
  if (!like.key) return std::nullopt;
  const std::string& group = like.key->first;
  const auto& groups = layers_.NamesOf(like.key->second->NamedBlock());
  if (!group.empty() && std::ranges::find(groups, group) == groups.end()) return std::nullopt;
  auto value = evaluator_.EvaluateParameter(*like.key);
  if (value && like.argument != nullptr) value = ArgumentLike(like, *value);
  if (!value || AsDistribution(*value)) return std::nullopt;
  if (like.component < 0) return value;
  const Eigen::Vector3d* parts = AsVector(*value);
  if (const schema::Ratio* ratio = AsRatio(*value)) parts = &ratio->parts;
  if (parts == nullptr) return std::nullopt;
  return (*parts)[like.component];
}

/// Reports the invalid values of a parameter, up to the number that a person would read.
void Configuration::ReportAll(const DependentParameter& parameter) {
  constexpr int kMost = 1000;
  const Point here = point_;
  std::vector<std::size_t> extents;
  for (const std::size_t axis : parameter.axes) extents.push_back(axes_[axis].values.size());
  Point at(parameter.axes.size(), 0);
  for (int i = 0; i < kMost; ++i) {
    Point point = here;
    for (std::size_t a = 0; a < at.size(); ++a) point[parameter.axes[a]] = at[a];
    Choose(point);
    ValueOf(parameter.key);
    if (!Advance(at, extents)) break;
  }
  Choose(here);
}

std::optional<Value> Configuration::ValueOf(const scenario::ParameterKey& key) {
  if (faulty_.contains(key)) return std::nullopt;
  const schema::Parameter& parameter = *key.second;
  const auto set = layers_.settings.find(key);
  const dsl::Setting& setting =
      set != layers_.settings.end() ? *set->second.node : names::DefaultSetting(parameter);
  const scenario::Scope scope =
      set != layers_.settings.end() ? set->second.scope : scenario::Scope{};
  if (parameter.type == schema::ParameterType::kWords) {
    std::vector<std::pair<Value, text::Span>> words;
    for (const auto& expr : setting.values) {
      const auto word = evaluator_.Evaluate(*expr, scope);
      if (!word) return std::nullopt;
      words.emplace_back(*word, evaluator_.sweeps().Origin(*expr, scope).span);
    }
    return evaluate::ConvertList(words, parameter, evaluator_.diagnostics());
  }
  if (setting.values.size() > 1) {
    evaluator_.diagnostics().Report(
        scenario::kWrongKind, Join(setting.values.front()->span, setting.values.back()->span),
        fmt::format("'{}' takes one value, but there are {}", parameter.name,
                    setting.values.size()),
        "sweep(…) makes a run for each, any(…) draws one for each object");
    return std::nullopt;
  }
  auto value = evaluator_.EvaluateParameter(key);
  if (value) value = evaluate::OfOwnGroup(std::move(*value), key, evaluator_);
  if (!value) return std::nullopt;
  return evaluator_.ConvertFor(parameter, *value, *setting.values[0], scope);
}

namespace {

using dsl::Expr;
using schema::Number;

bool CompareNumbers(const std::string& op, const Number& left, const Number& right) {
  const auto order = Compare(left, right);
  if (op == "==") return order == 0;
  if (op == "!=") return order != 0;
  if (op == "<") return order < 0;
  if (op == "<=") return order <= 0;
  if (op == ">") return order > 0;
  return order >= 0;
}

bool AreEqual(const Value& left, const Value& right) {
  if (AsVector(left) && AsVector(right)) return *AsVector(left) == *AsVector(right);
  return AsNumber(left) == nullptr && AsNumber(right) == nullptr && LabelOf(left) == LabelOf(right);
}

}  // namespace

void Conditions::SetAxis(const std::string& name, Value value) {
  axis_values_.insert_or_assign(name, std::move(value));
}

void Conditions::SetAxisWords(const std::string& name, std::vector<std::string> words) {
  axis_words_.insert_or_assign(name, std::move(words));
}

bool Conditions::Hold(const dsl::Condition& condition, const scenario::Scope& scope) {
  using enum dsl::ConditionKind;
  switch (condition.kind) {
    case kNot:
      return !Hold(*condition.items[0], scope);
    case kAnd:
    case kOr: {
      // Both sides are always evaluated, so that every error is found.
      const bool left = Hold(*condition.items[0], scope);
      const bool right = Hold(*condition.items[1], scope);
      return condition.kind == kAnd ? left && right : left || right;
    }
    case kIn: {
      bool is_one = false;
      for (const auto& value : condition.values)
        is_one = Compare(*condition.left, "==", *value, condition.span, scope) || is_one;
      return is_one;
    }
    case kCompare:
      break;
  }
  return Compare(*condition.left, condition.op, *condition.right, condition.span, scope);
}

void Conditions::CheckCalls(const dsl::Condition& condition) {
  for (const auto& item : condition.items) CheckCalls(*item);
  if (condition.left) RefuseCall(*condition.left);
  if (condition.right) RefuseCall(*condition.right);
  for (const auto& value : condition.values) RefuseCall(*value);
}

/// A call in a condition does not have a single value: true, with a report.
bool Conditions::RefuseCall(const Expr& expr) {
  if (evaluate::IsSweep(expr)) {
    evaluator_.Error(scenario::kMisplacedSweep, expr.span, "a condition cannot contain a sweep",
                     "sweep a setting or a let, and compare its name");
    return true;
  }
  if (expr.kind == ExprKind::kCall && schema::FindDistribution(expr.text)) {
    evaluator_.Error(
        scenario::kBadComparison, expr.span,
        fmt::format("{}() is drawn for each object and has no single value", expr.text),
        "conditions can compare axes, lets and parameters");
    return true;
  }
  return std::ranges::any_of(expr.items, [this](const auto& item) { return RefuseCall(*item); }) ||
         std::ranges::any_of(expr.arguments,
                             [this](const auto& item) { return RefuseCall(*item.value); });
}

bool Conditions::Compare(const Expr& left_expr, const std::string& op, const Expr& right_expr,
                         const text::Span& span, const scenario::Scope& scope) {
  if (RefuseCall(left_expr) || RefuseCall(right_expr)) return false;
  for (const bool swap : {false, true}) {
    const Expr& word = swap ? left_expr : right_expr;
    const Expr& other = swap ? right_expr : left_expr;
    if (IsLiteralWord(word, scope) && !CheckWord(word, other, scope)) return false;
  }
  const auto left = Comparand(left_expr, right_expr, scope);
  const auto right = Comparand(right_expr, left_expr, scope);
  if (!left || !right) return false;
  if (AsNumber(*left) && AsNumber(*right))
    return CompareNumbers(op, *AsNumber(*left), *AsNumber(*right));
  if (op != "==" && op != "!=") {
    evaluator_.Error(scenario::kBadComparison, span, fmt::format("'{}' compares only numbers", op),
                     "words are compared with == and !=");
    return false;
  }
  return (op == "==") == AreEqual(*left, *right);
}

std::optional<Value> Conditions::Comparand(const Expr& expr, const Expr& other,
                                           const scenario::Scope& scope) {
  if (expr.kind == ExprKind::kPath) {
    // Beside `omit`, `sleeping` is a component and not the switch of that name.
    const auto words = WordsOf(other, scope);
    if (std::ranges::find(words, expr.text) != words.end() &&
        !evaluator_.names().Resolve(expr.text, scope).let)
      return schema::Word{expr.text};
    const auto axis = axis_values_.find(expr.text);
    if (axis != axis_values_.end()) return axis->second;
  }
  auto value = evaluator_.Evaluate(expr, scope);
  if (!value || !AsFormula(*value)) return value;
  evaluate::RefuseFormula(*AsFormula(*value), evaluator_.diagnostics());
  return std::nullopt;
}

std::string Conditions::Nearest(std::string_view word, std::vector<std::string_view> words,
                                const scenario::Scope& scope) const {
  if (!words.empty()) return std::string(dsl::DidYouMean(word, words));
  for (const auto& [name, value] : axis_values_) words.push_back(name);
  if (const auto axis = dsl::DidYouMean(word, words); !axis.empty()) return std::string(axis);
  if (const auto let = evaluator_.names().NearestLet(std::string(word), scope); !let.empty())
    return std::string(let);
  // With several groups, a parameter has the name of one before it.
  words.clear();
  for (const schema::Parameter& parameter : schema::Schema()) {
    if (parameter.grouped && parameter.name == word && !evaluator_.layers().groups.empty())
      return fmt::format("{}.{}", evaluator_.layers().groups.front(), word);
    words.push_back(parameter.name);
  }
  return std::string(dsl::DidYouMean(word, words));
}

bool Conditions::CheckWord(const Expr& word, const Expr& other, const scenario::Scope& scope) {
  const std::vector<std::string_view> words = WordsOf(other, scope);
  if (other.kind == ExprKind::kPath && !axis_values_.contains(other.text) &&
      evaluator_.names().Resolve(other.text, scope).let)
    return true;
  if (std::ranges::find(words, word.text) != words.end()) return true;
  // It may be an axis with an error.
  if (words.empty() && evaluator_.layers().has_unread) return false;
  const std::string near = Nearest(word.text, words, scope);
  std::string help;
  if (!near.empty()) {
    help = fmt::format("did you mean '{}'?", near);
  } else if (!words.empty()) {
    help = fmt::format("it is one of {}", fmt::join(words, ", "));
  }
  evaluator_.Error(scenario::kUnknownName, word.span,
                   words.empty()
                       ? fmt::format("no axis, let or parameter is called '{}'", word.text)
                       : fmt::format("'{}' is never '{}'", other.text, word.text),
                   std::move(help));
  return false;
}

bool Conditions::IsLiteralWord(const Expr& expr, const scenario::Scope& scope) const {
  return expr.kind == ExprKind::kPath && expr.text != evaluate::kPiName &&
         !axis_values_.contains(expr.text) && evaluator_.names().Resolve(expr.text, scope).IsWord();
}

std::vector<std::string_view> Conditions::WordsOf(const Expr& expr,
                                                  const scenario::Scope& scope) const {
  if (expr.kind != ExprKind::kPath) return {};
  if (const auto axis = axis_words_.find(expr.text); axis != axis_words_.end())
    return {axis->second.begin(), axis->second.end()};
  if (axis_values_.contains(expr.text)) return {};
  const names::Referent referent = evaluator_.names().Resolve(expr.text, scope);
  if (!referent.parameter) return {};
  const schema::Parameter& parameter = *referent.parameter->second;
  std::vector<std::string_view> words = parameter.AllWords(evaluator_.scenario().plugins());
  for (const std::string_view call : parameter.AllCalls()) words.push_back(call);
  return words;
}

}  // namespace cdb::configure
