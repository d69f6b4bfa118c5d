#include "compiler/evaluate/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "compiler/evaluate/arguments.h"
#include "compiler/evaluate/defaults.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::evaluate {
namespace {

using dsl::Expr;
using dsl::ExprKind;

/// Visits every expression under `expr`, through lets and, where asked, parameters, each of those
/// once.
class Walker {
 public:
  Walker(const scenario::Layers& layers, const Evaluator& evaluator)
      : layers_(layers), evaluator_(evaluator) {}

  /// All sweeps that the value of `expr` depends on.
  void Sweeps(const Expr& expr, const scenario::Scope& scope, std::set<const Expr*>& found) {
    if (expr.kind == ExprKind::kCall && expr.text == "sweep") found.insert(&expr);
    for (const auto& item : expr.items) Sweeps(*item, scope, found);
    for (std::size_t i = 0; i < expr.arguments.size(); ++i) {
      const dsl::Argument& argument = expr.arguments[i];
      Sweeps(*argument.value, ArgumentScope(expr, i, scope), found);
      if (argument.weight) Sweeps(*argument.weight, scope, found);
    }
    if (expr.kind != ExprKind::kPath) return;
    const Referent referent = evaluator_.names().Resolve(expr.text, scope);
    if (referent.let && seen_.insert(referent.let->node).second)
      Sweeps(*referent.let->node->value, referent.let->scope, found);
    if (referent.parameter) Sweeps(*referent.parameter, found);
    if (!referent.is_object_count) return;
    for (const std::string& group : layers_.groups)
      Sweeps(scenario::ParameterKey{group, schema::GroupParameter("quantity").get()}, found);
  }

  void Sweeps(const scenario::ParameterKey& key, std::set<const Expr*>& found) {
    if (!seen_parameters_.insert(key).second) return;
    const auto setting = layers_.settings.find(key);
    if (setting != layers_.settings.end()) {
      for (const auto& value : setting->second.node->values)
        Sweeps(*value, setting->second.scope, found);
    } else {
      for (const auto& value : DefaultSetting(*key.second).values) Sweeps(*value, {}, found);
    }
  }

 private:
  const scenario::Layers& layers_;
  const Evaluator& evaluator_;
  std::set<const void*> seen_;
  std::set<scenario::ParameterKey> seen_parameters_;
};

class AxisFinder {
 public:
  AxisFinder(const scenario::Layers& layers, Evaluator& evaluator)
      : layers_(layers), evaluator_(evaluator) {}

  std::vector<SweepAxis> Find() {
    for (const auto& [key, setting] : layers_.settings) {
      const schema::Parameter& parameter = *key.second;
      // As it is called in its outermost block: `size`, `side`, `links_stiffness`.
      std::string full = parameter.FullName();
      std::string name = full.substr(full.find('.') + 1);
      std::ranges::replace(name, '.', '_');
      if (!key.first.empty() && key.first != "objects") name = key.first + "_" + name;
      if (parameter.grouped && key.first != "objects")
        full = key.first + "." + std::string(parameter.name);
      Statement statement{name, full, std::string(parameter.unit), key, setting.order, 0};
      for (const auto& value : setting.node->values)
        Walk(*value, setting.scope, statement, {value.get()});
    }
    std::ranges::sort(axes_, {}, &SweepAxis::order);
    Check();
    return std::move(axes_);
  }

 private:
  /// The setting or let that a sweep is written in.
  struct Statement {
    std::string name, parameter, unit;
    std::optional<scenario::ParameterKey> key;
    int order = 0;
    int count = 0;  ///< sweeps found in it so far
  };

  /// The part of a statement in which an expression stands.
  struct Part {
    const Expr* slot = nullptr;  ///< the whole value, vector component or argument
    const schema::ParametrisedWord* word = nullptr;
    const schema::Parameter* argument = nullptr;
    int component = -1;
  };

  void Walk(const Expr& expr, const scenario::Scope& scope, Statement& statement,
            const Part& part) {
    switch (expr.kind) {
      case ExprKind::kCall:
        if (expr.text == "sweep") {
          Add(expr, scope, statement, part);
          return;
        }
        for (std::size_t i = 0; i < expr.arguments.size(); ++i) {
          const dsl::Argument& argument = expr.arguments[i];
          Part inner = part;
          inner.slot = argument.value.get();
          if (const schema::ParametrisedWord* word = schema::FindParametrisedWord(expr.text)) {
            inner.word = word;
            inner.argument = ArgumentAt(*word, expr, i);
          }
          Walk(*argument.value, ArgumentScope(expr, i, scope), statement, inner);
          inner.slot = argument.weight.get();
          if (argument.weight) Walk(*argument.weight, scope, statement, inner);
        }
        return;
      case ExprKind::kVector:
      case ExprKind::kRatio:
        for (int i = 0; i < 3; ++i) {
          Part inner = part;
          inner.slot = expr.items[static_cast<std::size_t>(i)].get();
          inner.component = i;
          Walk(*inner.slot, scope, statement, inner);
        }
        return;
      case ExprKind::kPath: {
        const Referent referent = evaluator_.names().Resolve(expr.text, scope);
        if (!referent.let || !seen_.insert(referent.let->node).second) return;
        Statement let{referent.let->node->name.text, {}, {}, {}, referent.let->order, 0};
        const Expr& value = *referent.let->node->value;
        Walk(value, referent.let->scope, let, {&value});
        return;
      }
      default:
        for (const auto& item : expr.items) Walk(*item, scope, statement, part);
    }
  }

  void Add(const Expr& call, const scenario::Scope& scope, Statement& statement, const Part& part) {
    if (!seen_.insert(&call).second) return;
    SweepAxis axis;
    axis.call = &call;
    axis.name = statement.name;
    if (part.argument != nullptr) axis.name += "_" + std::string(part.argument->name);
    if (part.component >= 0) axis.name += std::string("_") + "xyz"[part.component];
    if (call.axis) axis.name = call.axis->text;
    axis.span = call.axis ? call.axis->span : call.span;
    axis.parameter = statement.parameter;
    const bool own_unit =
        part.argument != nullptr && part.argument->unit != schema::kParametersUnit;
    axis.unit = own_unit ? std::string(part.argument->unit) : statement.unit;
    axis.key = statement.key;
    axis.word = part.word;
    axis.argument = part.argument;
    axis.component = part.component;
    axis.order = {statement.order, statement.count++};
    const Sweep* sweep = evaluator_.sweeps().Find(call, scope);
    if (sweep == nullptr) return;

    // In `20 * sweep(1, 2)` the axis is what comes out, unless another axis has a part in it.
    std::set<const Expr*> in_slot;
    Walker(layers_, evaluator_).Sweeps(*part.slot, scope, in_slot);
    const bool alone = in_slot.size() == 1 && !call.axis;
    std::vector<Term> terms;
    for (std::size_t i = 0; i < sweep->items.size(); ++i) {
      evaluator_.Choose(call, i);
      const auto term = evaluator_.Evaluate(alone ? *part.slot : call, scope);
      if (!term) return;
      terms.push_back(*term);
    }
    evaluator_.Choose(call, 0);
    // A whole number that a double would round is a label rather than a wrong number.
    const bool numbers = std::ranges::all_of(terms, [](const Term& term) {
      return term.number() && Compare(Number::Real(term.number()->AsReal()), *term.number()) == 0 &&
             (!term.number()->is_whole() || std::abs(term.number()->AsReal()) <= 0x1p53);
    });
    for (const Term& term : terms) {
      if (numbers) {
        axis.values.emplace_back(term.number()->AsReal());
      } else {
        axis.values.emplace_back(ToText(term));
      }
    }
    for (std::size_t i = 1; i < axis.values.size(); ++i)
      if (std::find(axis.values.begin(), axis.values.begin() + static_cast<std::ptrdiff_t>(i),
                    axis.values[i]) != axis.values.begin() + static_cast<std::ptrdiff_t>(i))
        evaluator_.diagnostics().Report(
            scenario::kBadArguments,
            sweep->items[i].expr != nullptr ? sweep->items[i].expr->span : call.span,
            fmt::format("the value {} is on this axis twice", ToText(terms[i])),
            "`repeats` measures a point more than once");
    axes_.push_back(std::move(axis));
  }

  void Check() {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const SweepAxis& axis = axes_[i];
      for (std::size_t j = 0; j < i; ++j) {
        if (axes_[j].name != axis.name) continue;
        evaluator_.diagnostics().Report(
            scenario::kAxisTwice, axis.span,
            fmt::format("there is an axis '{}' already", axis.name),
            fmt::format("name one of them: sweep(…) as {}_2", axis.name),
            {{axes_[j].span, "the first is here"}});
      }
    }
  }

  const scenario::Layers& layers_;
  Evaluator& evaluator_;
  std::set<const void*> seen_;
  std::vector<SweepAxis> axes_;
};

}  // namespace

std::vector<SweepAxis> FindAxes(const scenario::Layers& layers, Evaluator& evaluator) {
  return AxisFinder(layers, evaluator).Find();
}

std::vector<std::size_t> Dependencies(const scenario::ParameterKey& key,
                                      const scenario::Layers& layers,
                                      const std::vector<SweepAxis>& axes,
                                      const Evaluator& evaluator) {
  std::set<const Expr*> found;
  Walker(layers, evaluator).Sweeps(key, found);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (found.contains(axes[i].call)) indices.push_back(i);
  return indices;
}

}  // namespace cdb::evaluate
