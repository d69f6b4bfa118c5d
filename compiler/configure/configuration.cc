#include "compiler/configure/configuration.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "compiler/configure/dependencies.h"
#include "compiler/evaluate/convert.h"
#include "compiler/evaluate/dimensions.h"
#include "compiler/evaluate/drawn_settings.h"
#include "compiler/names/defaults.h"
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
  for (const schema::Parameter& parameter : schema::Schema()) {
    if (!parameter.grouped) {
      Add({"", &parameter});
      continue;
    }
    for (const std::string& group : layers_.groups) Add({group, &parameter});
  }
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
  if (!group.empty() && std::ranges::find(layers_.groups, group) == layers_.groups.end())
    return std::nullopt;
  auto value = evaluator_.EvaluateParameter(*like.key);
  if (value && like.argument != nullptr) value = ArgumentLike(like, *value);
  if (!value || AsDistribution(*value)) return std::nullopt;
  if (like.component < 0) return value;
  const Eigen::Vector3d* parts = AsVector(*value);
  if (const schema::Ratio* ratio = AsRatio(*value)) parts = &ratio->parts;
  if (parts == nullptr) return std::nullopt;
  return (*parts)[like.component];
}

void Configuration::Add(const scenario::ParameterKey& key) {
  parameters_.push_back({key, Dependencies(key, layers_, axes_, evaluator_)});
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

}  // namespace cdb::configure
