#include "compiler/configure/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <unordered_set>
#include <utility>

#include "compiler/evaluate/evaluate.h"
#include "compiler/names/names.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::configure {
namespace {

using dsl::Expr;
using dsl::ExprKind;
using schema::Number;
using schema::Value;

/// A large integer that a double would round becomes a label, not a wrong number.
bool IsExactNumber(const Value& value) {
  const Number* number = AsNumber(value);
  if (number == nullptr) return false;
  const double real = number->AsReal();
  return Compare(Number(real), *number) == 0 && (!number->is_whole() || std::abs(real) <= 0x1p53);
}

class AxisFinder {
 public:
  AxisFinder(const scenario::Layers& layers, evaluate::Evaluator& evaluator)
      : layers_(layers), evaluator_(evaluator) {}

  std::vector<SweepAxis> Find() {
    for (const auto& [key, setting] : layers_.settings) {
      Statement statement = StatementOf(key, setting.order);
      for (const auto& value : setting.node->values)
        Walk(*value, setting.scope, statement, {value.get()});
    }
    std::ranges::sort(axes_, {}, &SweepAxis::order);
    CheckNames();
    return std::move(axes_);
  }

 private:
  /// The setting or let that contains a sweep.
  struct Statement {
    std::string name, parameter, unit;
    std::optional<scenario::ParameterKey> key;
    int order = 0;
    int count = 0;  ///< sweeps found in it so far
  };

  /// The part of a statement that contains an expression.
  struct Part {
    const Expr* slot = nullptr;  ///< the whole value, vector component or argument
    const schema::ParametrisedWord* word = nullptr;
    const schema::Parameter* argument = nullptr;
    int component = -1;
    const Expr* quantity = nullptr;  ///< `sweep( ) ms`: the sweep with its unit
  };

  Statement StatementOf(const scenario::ParameterKey& key, int order) const {
    const schema::Parameter& parameter = *key.second;
    // The name within its outermost block: `size`, `side`, `links_stiffness`.
    std::string full = parameter.FullName();
    std::string name = full.substr(full.find('.') + 1);
    if (parameter.grouped && key.first != "objects") full = key.first + "." + name;
    if (parameter.grouped && key.first != "objects") name = key.first + "_" + name;
    std::ranges::replace(name, '.', '_');
    return {name, full, std::string(evaluate::UnitOf(key, evaluator_)), key, order, 0};
  }

  void Walk(const Expr& expr, const scenario::Scope& scope, Statement& statement,
            const Part& part) {
    switch (expr.kind) {
      case ExprKind::kCall:
        return WalkCall(expr, scope, statement, part);
      case ExprKind::kVector:
      case ExprKind::kRatio:
        for (int i = 0; i < 3; ++i) {
          Part inner = part;
          inner.slot = expr.items[static_cast<std::size_t>(i)].get();
          inner.component = i;
          Walk(*inner.slot, scope, statement, inner);
        }
        return;
      case ExprKind::kQuantity: {
        Part inner = part;
        inner.quantity = &expr;
        return Walk(*expr.items[0], scope, statement, inner);
      }
      case ExprKind::kPath:
        return WalkLet(evaluator_.names().Resolve(expr.text, scope));
      default:
        for (const auto& item : expr.items) Walk(*item, scope, statement, part);
    }
  }

  void WalkCall(const Expr& call, const scenario::Scope& scope, Statement& statement,
                const Part& part) {
    if (evaluate::IsSweep(call)) return Add(call, scope, statement, part);
    if (evaluate::IsFunction(call.text)) {
      for (const dsl::Argument& argument : call.arguments)
        Walk(*argument.value, scope, statement, part);
      return;
    }
    // Nothing is known of the arguments of an unknown function.
    if (!schema::FindDistribution(call.text) && schema::FindParametrisedWord(call.text) == nullptr)
      return;
    for (const auto& limit : call.items) {
      Part inner = part;
      inner.slot = limit.get();
      Walk(*limit, scope, statement, inner);
    }
    for (std::size_t i = 0; i < call.arguments.size(); ++i) {
      const dsl::Argument& argument = call.arguments[i];
      Part inner = part;
      inner.slot = argument.value.get();
      if (const schema::ParametrisedWord* word = schema::FindParametrisedWord(call.text)) {
        inner.word = word;
        // A point replaces all arguments: its axis is named after the component.
        const bool is_point = word->takes_points && argument.value->kind == ExprKind::kVector;
        if (!is_point) inner.argument = names::ArgumentAt(*word, call, i);
      }
      Walk(*argument.value, names::ArgumentScope(call, i, scope), statement, inner);
      inner.slot = argument.weight.get();
      if (argument.weight) Walk(*argument.weight, scope, statement, inner);
    }
  }

  /// A let used by several statements is walked once.
  void WalkLet(const names::Referent& referent) {
    if (!referent.let || !seen_.insert(referent.let->node).second) return;
    const dsl::Let& let = *referent.let->node;
    Statement statement{let.name.text, {}, {}, {}, referent.let->order, 0};
    Walk(*let.value, referent.let->scope, statement, {let.value.get()});
  }

  void Add(const Expr& call, const scenario::Scope& scope, Statement& statement, const Part& part) {
    if (call.zip) return AddZip(*call.zip, scope, statement);
    if (!seen_.insert(&call).second) return;
    SweepAxis axis = Describe(call, statement, part);
    const evaluate::Sweep* sweep = evaluator_.sweeps().Find(call, scope);
    if (sweep == nullptr || !CountPoints(sweep->items.size(), axis.span)) return;
    bool is_factor = false;
    const auto values = Evaluate(call, *sweep, scope, part, is_factor);
    if (!values) return;
    if (is_factor) axis.unit.clear();
    axis.values = Coordinates(*values);
    axis.scope = scope;
    axis.is_log = sweep->is_log;
    CheckDistinct(axis, *sweep, *values);
    if (evaluate::IsFind(call)) CheckOrder(axis);
    if (evaluate::IsRace(call) && axis.values.size() < 2)
      evaluator_.Error(scenario::kBadArguments, axis.call->span,
                       "race() has one value, which has nobody to race",
                       "for example: race(sap, dbvt, auto)");
    axes_.push_back(std::move(axis));
  }

  void CheckOrder(const SweepAxis& axis) {
    const auto value = [&](std::size_t i) { return std::get_if<double>(&axis.values[i]); };
    bool is_ordered = value(0) != nullptr;
    for (std::size_t i = 1; i < axis.values.size() && is_ordered; ++i)
      is_ordered = (*value(i) > *value(i - 1)) == (*value(1) > *value(0));
    if (!is_ordered)
      evaluator_.Error(scenario::kBadArguments, axis.call->span,
                       "find() looks for a boundary along numbers that ascend or descend",
                       "for example: find(1 .. 1000 log, until: verdict != stable)");
    else if (axis.values.size() < 2)
      evaluator_.Error(scenario::kBadArguments, axis.call->span,
                       "find() has one value, and there is nothing beside it",
                       "for example: find(1 .. 1000 log, until: verdict != stable)");
  }

  /// One axis, with the values of the first sweep; if these are not distinct, with joined labels of
  /// all sweeps.
  void AddZip(const dsl::Zip& zip, const scenario::Scope& scope, Statement& statement) {
    const Expr& first = *zip.sweeps[0];
    if (!seen_.insert(&first).second) return;
    std::vector<std::vector<Value>> columns;
    std::vector<std::string> lengths;
    bool is_even = true;
    for (const Expr* sweep : zip.sweeps) {
      const evaluate::Sweep* found = evaluator_.sweeps().Find(*sweep, scope);
      if (found == nullptr) return;
      lengths.push_back(fmt::format("{}", found->items.size()));
      is_even =
          is_even && found->items.size() == evaluator_.sweeps().Find(first, scope)->items.size();
    }
    if (!is_even) {
      evaluator_.Error(
          scenario::kBadArguments, zip.span,
          fmt::format("the sweeps of zip() have {} values", fmt::join(lengths, " and ")),
          "sweeps that change together must have the same number of values");
      return;
    }
    if (!CountPoints(evaluator_.sweeps().Find(first, scope)->items.size(), zip.span)) return;
    for (const Expr* sweep : zip.sweeps) {
      bool is_factor = false;
      const auto values =
          Evaluate(*sweep, *evaluator_.sweeps().Find(*sweep, scope), scope, {sweep}, is_factor);
      if (!values) return;
      columns.push_back(*values);
    }
    SweepAxis axis = Describe(first, statement, {&first});
    axis.name = zip.axis ? zip.axis->text : zip.names[0].text;
    axis.span = zip.axis ? zip.axis->span : zip.span;
    axis.title = zip.axis_title;
    if (IsSampledZip(zip, scope)) {
      if (AddSampled(zip, scope, columns, axis)) axes_.push_back(std::move(axis));
      return;
    }
    axis.values = Coordinates(columns[0]);
    const std::unordered_set<plan::Coordinate> distinct(axis.values.begin(), axis.values.end());
    if (distinct.size() < axis.values.size()) axis.values = JoinedLabels(columns);
    CheckDistinct(axis, *evaluator_.sweeps().Find(first, scope), columns[0]);
    axes_.push_back(std::move(axis));
  }

  bool IsSampledZip(const dsl::Zip& zip, const scenario::Scope& scope) {
    return std::ranges::any_of(zip.sweeps, [&](const Expr* sweep) {
      return evaluator_.sweeps().Find(*sweep, scope)->sampled.has_value();
    });
  }

  /// Sets the values to the numbers of the points. False after a diagnostic.
  bool AddSampled(const dsl::Zip& zip, const scenario::Scope& scope,
                  const std::vector<std::vector<Value>>& columns, SweepAxis& axis) {
    const auto fail = [&](const char* message, const char* help) {
      evaluator_.Error(scenario::kBadArguments, zip.span, message, help);
      return false;
    };
    if (!zip.axis) return fail("these points have no name", "name their axis: zip(…) as design");
    for (std::size_t i = 0; i < zip.sweeps.size(); ++i) {
      const evaluate::Sweep* sweep = evaluator_.sweeps().Find(*zip.sweeps[i], scope);
      if (!sweep->sampled ||
          sweep->sampled != evaluator_.sweeps().Find(*zip.sweeps[0], scope)->sampled)
        return fail("only some of these ranges are sampled, or not in the same way",
                    "write the same word in all of them: zip(sweep(1 .. 5 sobol 64), sweep(0 .. 1 "
                    "sobol 64))");
      plan::Coordinates coordinates{
          zip.names[i].text, sweep->ends.first, sweep->ends.second, sweep->is_log, {}};
      for (const Value& value : columns[i]) coordinates.values.push_back(AsNumber(value)->AsReal());
      axis.sampled.push_back(std::move(coordinates));
    }
    for (std::size_t i = 0; i < columns[0].size(); ++i)
      axis.values.emplace_back(static_cast<double>(i + 1));
    return true;
  }

  /// False, with a diagnostic, if there are too many points with another axis of `values` values.
  /// To evaluate those values would take seconds and hundreds of megabytes.
  bool CountPoints(std::size_t values, text::Span span) {
    points_ *= static_cast<double>(values);
    if (points_ <= kMostRuns || !layers_.skips.empty()) return true;
    evaluator_.Error(scenario::kTooManyRuns, span,
                     fmt::format("with this sweep there are {:.15g} points", points_),
                     fmt::format("a benchmark has at most {:.15g} runs: sweep fewer values, leave "
                                 "some out by `skip`, or split the benchmark",
                                 kMostRuns));
    return false;
  }

  static std::vector<plan::Coordinate> JoinedLabels(
      const std::vector<std::vector<Value>>& columns) {
    std::vector<plan::Coordinate> labels;
    for (std::size_t i = 0; i < columns[0].size(); ++i) {
      std::vector<std::string> parts;
      for (const std::vector<Value>& column : columns) parts.push_back(LabelOf(column[i]));
      labels.emplace_back(fmt::format("{}", fmt::join(parts, ", ")));
    }
    return labels;
  }

  /// An axis without its values.
  static SweepAxis Describe(const Expr& call, Statement& statement, const Part& part) {
    SweepAxis axis;
    axis.call = &call;
    axis.name = statement.name;
    if (part.argument != nullptr) axis.name += "_" + std::string(part.argument->name);
    if (part.component >= 0) axis.name += std::string("_") + "xyz"[part.component];
    if (call.axis) axis.name = call.axis->text;
    axis.span = call.axis ? call.axis->span : call.span;
    axis.parameter = statement.parameter;
    axis.title = call.axis_title;
    const bool has_own_unit =
        part.argument != nullptr && part.argument->unit != schema::kParametersUnit;
    axis.unit = has_own_unit ? std::string(part.argument->unit) : statement.unit;
    if (part.argument == nullptr && part.word != nullptr)
      axis.unit = part.word->arguments[0].unit;  // the unit of a point
    axis.key = statement.key;
    axis.word = part.word;
    axis.argument = part.argument;
    axis.component = part.component;
    axis.order = {statement.order, statement.count++};
    return axis;
  }

  /// The values on the axis of `call`; nullopt after a diagnostic. For `20 * sweep(1, 2)` they are
  /// 20 and 40, unless another axis takes part. For `sweep(1, 2) * size`, which differs for each
  /// object, they are 1 and 2, and `is_factor` is set.
  std::optional<std::vector<Value>> Evaluate(const Expr& call, const evaluate::Sweep& sweep,
                                             const scenario::Scope& scope, const Part& part,
                                             bool& is_factor) {
    const bool alone = SweepsIn(*part.slot, scope, layers_, evaluator_).size() == 1 && !call.axis;
    std::vector<Value> values;
    for (std::size_t i = 0; i < sweep.items.size(); ++i) {
      evaluator_.Choose(call, i);
      const bool is_quantity = part.quantity != nullptr && part.quantity->items[0].get() == &call;
      const Expr& with_unit = is_quantity ? *part.quantity : call;
      auto value = evaluator_.Evaluate(alone ? *part.slot : with_unit, scope);
      is_factor = alone && value && AsFormula(*value) && part.slot != &with_unit;
      if (is_factor) value = evaluator_.Evaluate(with_unit, scope);
      if (!value) return std::nullopt;
      values.push_back(*value);
    }
    evaluator_.Choose(call, 0);
    return values;
  }

  static std::vector<plan::Coordinate> Coordinates(const std::vector<Value>& values) {
    const bool are_numbers = std::ranges::all_of(values, IsExactNumber);
    std::vector<plan::Coordinate> coordinates;
    for (const Value& value : values)
      coordinates.push_back(are_numbers ? CoordinateOf(value) : LabelOf(value));
    return coordinates;
  }

  /// True for `sweep(100 .. 1000, 100)`.
  static bool IsRangeAndStep(const Expr& call) {
    return call.arguments.size() == 2 && call.arguments[0].value->kind == ExprKind::kRange &&
           call.arguments[0].value->range == dsl::RangeKind::kByOne &&
           call.arguments[1].value->kind == ExprKind::kNumber;
  }

  void CheckDistinct(const SweepAxis& axis, const evaluate::Sweep& sweep,
                     const std::vector<Value>& values) {
    std::unordered_set<plan::Coordinate> seen;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (seen.insert(axis.values[i]).second) continue;
      const Expr* item = sweep.items[i].expr;
      evaluator_.diagnostics().Report(
          scenario::kBadArguments, item != nullptr ? item->span : axis.call->span,
          fmt::format("the value {} is on this axis twice", LabelOf(values[i])),
          IsRangeAndStep(*axis.call)
              ? fmt::format("for steps of {}, write sweep({} step {})", text::TextOf(item->span),
                            text::TextOf(axis.call->arguments[0].value->span),
                            text::TextOf(item->span))
              : "to measure a point several times, use `repeats`");
    }
  }

  void CheckNames() {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const SweepAxis& axis = axes_[i];
      for (std::size_t j = 0; j < i; ++j) {
        if (axes_[j].name != axis.name) continue;
        evaluator_.diagnostics().Report(
            scenario::kAxisTwice, axis.span,
            fmt::format("there is already an axis '{}'", axis.name),
            fmt::format("name one of them: sweep(…) as {}_2", axis.name),
            {{axes_[j].span, "the first is here"}});
      }
    }
  }

  const scenario::Layers& layers_;
  evaluate::Evaluator& evaluator_;
  std::set<const void*> seen_;
  std::vector<SweepAxis> axes_;
  double points_ = 1;
};

}  // namespace

plan::Coordinate CoordinateOf(const Value& value) {
  if (const Number* number = AsNumber(value)) return number->AsReal();
  return LabelOf(value);
}

std::vector<SweepAxis> FindAxes(const scenario::Layers& layers, evaluate::Evaluator& evaluator) {
  return AxisFinder(layers, evaluator).Find();
}

namespace {

/// Collects the sweeps that values depend on; visits each let and each parameter once.
class Collector {
 public:
  Collector(const scenario::Layers& layers, const evaluate::Evaluator& evaluator)
      : layers_(layers), evaluator_(evaluator) {}

  using Sweeps = std::set<const Expr*>;
  const Sweeps& Of(const scenario::ParameterKey& key) { return Visit(key).found.sweeps; }
  const Sweeps& Of(const Expr& expr, const scenario::Scope& scope) {
    return Visit({"", &expr}, [&] { Add(expr, scope); }).found.sweeps;
  }

 private:
  struct Found {
    Sweeps sweeps;
    bool is_relative = false;  ///< a layout has as many objects as another group
    void Add(const Found& other) {
      sweeps.insert(other.sweeps.begin(), other.sweeps.end());
      is_relative = is_relative || other.is_relative;
    }
  };
  /// A let or a parameter: the group, and what it is.
  using Id = std::pair<std::string, const void*>;
  /// Nodes that depend on each other are found together: R. Tarjan, Depth-first search and linear
  /// graph algorithms, 1972.
  struct Node {
    Found found;
    std::size_t index = 0;  ///< in the order of visits
    std::size_t low = 0;    ///< the first open node that it is known to depend on
    bool is_open = true;    ///< it may depend on more
  };

  template <typename AddAll>
  const Node& Visit(const Id& id, AddAll add_all) {
    const auto [at, is_new] = nodes_.try_emplace(id);
    Node& node = at->second;
    if (is_new) {
      node.index = node.low = nodes_.size();
      open_.push_back(&node);
      Node* const above = std::exchange(here_, &node);
      add_all();
      here_ = above;
      if (node.low == node.index) Close(node);
    }
    if (here_ == nullptr) return node;
    here_->found.Add(node.found);
    if (node.is_open) here_->low = std::min(here_->low, node.low);
    return node;
  }
  const Node& Visit(const scenario::ParameterKey& key) {
    return Visit({key.first, key.second}, [&] { AddParameter(key); });
  }

  /// The open nodes from this one on depend on each other.
  void Close(const Node& first) {
    const auto from = std::ranges::find(open_.rbegin(), open_.rend(), &first).base() - 1;
    Found all;
    for (auto node = from; node != open_.end(); ++node) all.Add((*node)->found);
    for (auto node = from; node != open_.end(); ++node) {
      (*node)->found = all;
      (*node)->is_open = false;
    }
    open_.erase(from, open_.end());
  }

  void Add(const Expr& expr, const scenario::Scope& scope) {
    Found& found = here_->found;
    found.is_relative =
        found.is_relative || (expr.kind == ExprKind::kCall && expr.text == schema::kRelativeCall);
    if (evaluate::IsSweep(expr)) found.sweeps.insert(expr.zip ? expr.zip->sweeps[0] : &expr);
    for (const auto& item : expr.items) Add(*item, scope);
    for (std::size_t i = 0; i < expr.arguments.size(); ++i) {
      const dsl::Argument& argument = expr.arguments[i];
      Add(*argument.value, names::ArgumentScope(expr, i, scope));
      if (argument.weight) Add(*argument.weight, scope);
    }
    if (expr.kind != ExprKind::kPath) return;
    const names::Referent referent = evaluator_.names().Resolve(expr.text, scope);
    if (referent.let)
      Visit({"", referent.let->node},
            [&] { Add(*referent.let->node->value, referent.let->scope); });
    if (referent.parameter) Visit(*referent.parameter);
    if (referent.measure)
      for (const schema::GroupParameter of : names::BoxMeasure::kOf)
        Visit(scenario::ParameterKey{referent.measure->group, of.get()});
    if (referent.is_object_count) AddQuantities();
  }

  void AddParameter(const scenario::ParameterKey& key) {
    const auto setting = layers_.settings.find(key);
    if (setting != layers_.settings.end()) {
      for (const auto& value : setting->second.node->values) Add(*value, setting->second.scope);
      return;
    }
    for (const auto& value : names::DefaultSetting(*key.second).values) Add(*value, {});
    // The layout may determine the quantity, and name another group with as many objects.
    if (key.second != schema::GroupParameter("quantity").get()) return;
    Visit(scenario::ParameterKey{key.first, schema::GroupParameter("location").get()});
    if (here_->found.is_relative) AddQuantities();
  }

  void AddQuantities() {
    for (const std::string& group : layers_.groups)
      Visit(scenario::ParameterKey{group, schema::GroupParameter("quantity").get()});
  }

  const scenario::Layers& layers_;
  const evaluate::Evaluator& evaluator_;
  std::map<Id, Node> nodes_;
  std::vector<Node*> open_;  ///< in the order of visits
  Node* here_ = nullptr;     ///< the one whose expressions are visited
};

}  // namespace

std::set<const Expr*> SweepsIn(const Expr& expr, const scenario::Scope& scope,
                               const scenario::Layers& layers,
                               const evaluate::Evaluator& evaluator) {
  return Collector(layers, evaluator).Of(expr, scope);
}

std::vector<std::vector<std::size_t>> Dependencies(std::span<const scenario::ParameterKey> keys,
                                                   const scenario::Layers& layers,
                                                   const std::vector<SweepAxis>& axes,
                                                   const evaluate::Evaluator& evaluator) {
  Collector collector(layers, evaluator);
  std::vector<std::vector<std::size_t>> all;
  for (const scenario::ParameterKey& key : keys) {
    const auto& sweeps = collector.Of(key);
    std::vector<std::size_t>& indices = all.emplace_back();
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (sweeps.contains(axes[i].call)) indices.push_back(i);
  }
  return all;
}

}  // namespace cdb::configure
