// A benchmark under one choice of its cases: its axes, and the scene at each of its points.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/configure/axes.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/plan/plan.h"
#include "compiler/scenario/layers.h"
#include "compiler/scenario/scenario.h"

namespace cdb::configure {

// Conditions: `skip when detector == sap and quantity > 100`.

class Conditions {
 public:
  explicit Conditions(evaluate::Evaluator& evaluator) : evaluator_(evaluator) {}

  /// Sets the value of axis `name`; conditions can use axes as well as lets and parameters.
  void SetAxis(const std::string& name, schema::Value value);
  /// All values of an axis of words: the words that a condition can compare it with.
  void SetAxisWords(const std::string& name, std::vector<std::string> words);
  bool HasAxisWords(const std::string& name) const { return axis_words_.contains(name); }

  /// Evaluates at the chosen point of the axes; false after a diagnostic.
  bool Hold(const dsl::Condition& condition, const scenario::Scope& scope);
  /// Reports calls that no condition can contain, whatever their names mean.
  void CheckCalls(const dsl::Condition& condition);

 private:
  /// A comparison by `op` at `span`.
  bool Compare(const dsl::Expr& left, const std::string& op, const dsl::Expr& right,
               const text::Span& span, const scenario::Scope& scope);
  /// One side of a comparison; `other` is the other side.
  std::optional<schema::Value> Comparand(const dsl::Expr& expr, const dsl::Expr& other,
                                         const scenario::Scope& scope);
  /// Whether `other` can be compared with `word`, which is not a name.
  bool RefuseCall(const dsl::Expr& expr);
  /// The nearest of `words`; without any, the nearest axis, let or parameter.
  std::string Nearest(std::string_view word, std::vector<std::string_view> words,
                      const scenario::Scope& scope) const;
  bool CheckWord(const dsl::Expr& word, const dsl::Expr& other, const scenario::Scope& scope);
  bool IsLiteralWord(const dsl::Expr& expr, const scenario::Scope& scope) const;
  /// The possible words of the axis or the parameter `expr`.
  std::vector<std::string_view> WordsOf(const dsl::Expr& expr, const scenario::Scope& scope) const;

  evaluate::Evaluator& evaluator_;
  std::map<std::string, schema::Value, std::less<>> axis_values_;
  std::map<std::string, std::vector<std::string>, std::less<>> axis_words_;
};

/// An index on each axis.
using Point = std::vector<std::size_t>;

/// Counts through all points of a grid, the last axis fastest. False at the end.
bool Advance(Point& point, const std::vector<std::size_t>& extents);

/// A parameter of the world or of one group, and the axes that its value depends on.
struct DependentParameter {
  scenario::ParameterKey key;
  std::vector<std::size_t> axes;  ///< into Configuration::axes
};

/// Reports every error. Not thread-safe.
class Configuration {
 public:
  Configuration(const scenario::Scenario& scenario, scenario::Layers layers,
                dsl::Diagnostics& diagnostics);

  const scenario::Scenario& scenario() const { return scenario_; }
  const scenario::Layers& layers() const { return layers_; }
  const std::vector<SweepAxis>& axes() const { return axes_; }
  evaluate::Evaluator& evaluator() { return evaluator_; }
  Conditions& conditions() { return conditions_; }

  /// Selects the point for all later calls.
  void Choose(const Point& point);

  const std::vector<DependentParameter>& parameters() const { return parameters_; }
  /// The value of a parameter at the chosen point; nullopt after a diagnostic.
  std::optional<schema::Value> ValueOf(const scenario::ParameterKey& key);
  /// Sets the seeds of a scene and the plug-ins it uses.
  void Complete(plan::Scene& scene) const;
  /// Checks each setting and each condition separately.
  void CheckSettings();

  bool IsSet(const scenario::ParameterKey& key) const { return layers_.settings.contains(key); }
  /// The location of a parameter's value at the chosen point, for diagnostics about it; `otherwise`
  /// if it is a default.
  text::Span SpanOf(const scenario::ParameterKey& key, const text::Span& otherwise);
  /// The location of one word in the list of `key`, at the chosen point.
  text::Span SpanOfWord(const scenario::ParameterKey& key, std::string_view word);

  /// Errors of units in settings; axes and conditions can be evaluated in spite of them.
  int unit_errors() const { return unit_errors_; }
  /// The value here for axis `like` of another configuration, if it is not swept here.
  std::optional<schema::Value> ConstantFor(const SweepAxis& like);

 private:
  void ReportAll(const DependentParameter& parameter);

  const scenario::Scenario& scenario_;
  scenario::Layers layers_;
  evaluate::Evaluator evaluator_;
  Conditions conditions_;
  std::vector<SweepAxis> axes_;
  int unit_errors_ = 0;
  std::set<scenario::ParameterKey> faulty_;  ///< settings with reported errors, not evaluated
  std::vector<DependentParameter> parameters_;
  Point point_;
};

}  // namespace cdb::configure
