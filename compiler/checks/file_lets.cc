#include "compiler/checks/file_lets.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <variant>

#include "compiler/checks/idle_settings.h"
#include "compiler/evaluate/dimensions.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/scenario/diagnostic_kinds.h"

namespace cdb::checks {
namespace {

/// The names that occur in expressions, and the groups of objects.
class NameCollector {
 public:
  void Add(const dsl::File& file) {
    for (const auto& item : file.items) {
      if (const auto* let = std::get_if<dsl::Let>(&item)) Add(*let->value);
      if (const auto* benchmark = std::get_if<dsl::Benchmark>(&item)) Add(benchmark->block);
    }
  }

  const std::set<std::string_view>& names() const { return names_; }
  const std::set<std::string>& groups() const { return groups_; }

 private:
  void Add(const dsl::Expr& expr) {
    if (expr.kind == dsl::ExprKind::kPath) names_.insert(expr.text);
    for (const auto& item : expr.items) Add(*item);
    for (const dsl::Argument& argument : expr.arguments) {
      Add(*argument.value);
      if (argument.weight) Add(*argument.weight);
    }
  }
  void Add(const dsl::Condition& condition) {
    if (condition.left) Add(*condition.left);
    if (condition.right) Add(*condition.right);
    for (const auto& value : condition.values) Add(*value);
    for (const auto& item : condition.items) Add(*item);
  }
  void Add(const dsl::Block& block) {
    for (const dsl::Statement& statement : block.statements) {
      if (const auto* let = std::get_if<dsl::Let>(&statement.what)) {
        Add(*let->value);
      } else if (const auto* cases = std::get_if<dsl::Cases>(&statement.what)) {
        for (const dsl::Case& one : cases->cases) Add(one.block);
      } else if (const auto* skip = std::get_if<dsl::Skip>(&statement.what)) {
        if (skip->when) Add(*skip->when);
      } else if (const auto* require = std::get_if<dsl::Require>(&statement.what)) {
        if (require->what) Add(*require->what);
      } else if (const auto* group = std::get_if<dsl::Group>(&statement.what)) {
        if (group->label) groups_.insert(group->label->text);
        Add(group->block);
      } else if (const auto* setting = std::get_if<dsl::Setting>(&statement.what)) {
        for (const auto& value : setting->values) Add(*value);
      }
    }
  }

  std::set<std::string_view> names_;
  std::set<std::string> groups_;
};

}  // namespace

void CheckFileLets(const scenario::Scenario& scenario, dsl::Diagnostics& diagnostics) {
  const dsl::File& file = scenario.main()->tree;
  NameCollector used;
  used.Add(file);
  // A file with only lets is meant for use by others.
  const bool is_for_others = scenario.Benchmarks().empty();
  scenario::Layers layers;
  layers.groups = {used.groups().begin(), used.groups().end()};
  layers.groups.emplace_back("objects");
  layers.is_incomplete = !scenario.is_complete();
  dsl::Diagnostics found;
  evaluate::Evaluator evaluator(scenario, layers, found);
  evaluate::Dimensions dimensions(layers, evaluator);
  std::size_t seen = 0;
  for (const auto& item : file.items) {
    const auto* let = std::get_if<dsl::Let>(&item);
    if (let == nullptr || let->value->kind == dsl::ExprKind::kRange) continue;
    evaluator.Evaluate(*let->value, {scenario.main(), {}, {}, nullptr});
    dimensions.CheckLet(*let, {scenario.main(), {}, {}, nullptr});
    const bool is_unused = !is_for_others && !used.names().contains(let->name.text);
    if (is_unused) ReportUnusedSweep(*let, diagnostics);
    for (; seen < found.all().size(); ++seen) {
      const dsl::Diagnostic& fault = found.all()[seen];
      if (is_unused || fault.kind->is_of_expression)
        diagnostics.Report(*fault.kind, fault.span, fault.message, fault.help, fault.notes);
    }
  }
}

}  // namespace cdb::checks
