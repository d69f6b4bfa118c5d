#include "compiler/configure/dependencies.h"

#include "compiler/names/arguments.h"
#include "compiler/names/defaults.h"

namespace cdb::configure {
namespace {

using dsl::Expr;
using dsl::ExprKind;

/// Collects sweeps; visits each let and each parameter once.
class Collector {
 public:
  Collector(const scenario::Layers& layers, const evaluate::Evaluator& evaluator)
      : layers_(layers), evaluator_(evaluator) {}

  void Add(const Expr& expr, const scenario::Scope& scope) {
    if (expr.kind == ExprKind::kCall && expr.text == "sweep")
      found_.insert(expr.zip ? expr.zip->sweeps[0] : &expr);
    for (const auto& item : expr.items) Add(*item, scope);
    for (std::size_t i = 0; i < expr.arguments.size(); ++i) {
      const dsl::Argument& argument = expr.arguments[i];
      Add(*argument.value, names::ArgumentScope(expr, i, scope));
      if (argument.weight) Add(*argument.weight, scope);
    }
    if (expr.kind != ExprKind::kPath) return;
    const names::Referent referent = evaluator_.names().Resolve(expr.text, scope);
    if (referent.let && seen_.insert(referent.let->node).second)
      Add(*referent.let->node->value, referent.let->scope);
    if (referent.parameter) Add(*referent.parameter);
    if (!referent.is_object_count) return;
    for (const std::string& group : layers_.groups)
      Add(scenario::ParameterKey{group, schema::GroupParameter("quantity").get()});
  }

  void Add(const scenario::ParameterKey& key) {
    if (!seen_parameters_.insert(key).second) return;
    const auto setting = layers_.settings.find(key);
    if (setting != layers_.settings.end()) {
      for (const auto& value : setting->second.node->values) Add(*value, setting->second.scope);
    } else {
      for (const auto& value : names::DefaultSetting(*key.second).values) Add(*value, {});
      // The layout may determine the quantity.
      if (key.second == schema::GroupParameter("quantity").get())
        Add(scenario::ParameterKey{key.first, schema::GroupParameter("location").get()});
    }
  }

  const std::set<const Expr*>& found() const { return found_; }

 private:
  const scenario::Layers& layers_;
  const evaluate::Evaluator& evaluator_;
  std::set<const Expr*> found_;
  std::set<const void*> seen_;
  std::set<scenario::ParameterKey> seen_parameters_;
};

}  // namespace

std::set<const Expr*> SweepsIn(const Expr& expr, const scenario::Scope& scope,
                               const scenario::Layers& layers,
                               const evaluate::Evaluator& evaluator) {
  Collector collector(layers, evaluator);
  collector.Add(expr, scope);
  return collector.found();
}

std::vector<std::size_t> Dependencies(const scenario::ParameterKey& key,
                                      const scenario::Layers& layers,
                                      const std::vector<SweepAxis>& axes,
                                      const evaluate::Evaluator& evaluator) {
  Collector collector(layers, evaluator);
  collector.Add(key);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (collector.found().contains(axes[i].call)) indices.push_back(i);
  return indices;
}

}  // namespace cdb::configure
