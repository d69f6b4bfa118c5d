// Evaluates expressions for one choice of a value on every axis.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/evaluate/sweeps.h"
#include "compiler/names/names.h"
#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

/// Evaluates the expressions of one `Layers`. Every error is reported once, and gives nullopt.
class Evaluator {
 public:
  Evaluator(const scenario::Scenario& scenario, const scenario::Layers& layers,
            dsl::Diagnostics& diagnostics);
  Evaluator(const Evaluator&) = delete;

  /// The value at the chosen point of the axes.
  std::optional<schema::Value> Evaluate(const dsl::Expr& expr, const scenario::Scope& scope);
  /// `what`: a plural noun for `expr`, for messages.
  std::optional<schema::Number> EvaluateNumber(const dsl::Expr& expr, const scenario::Scope& scope,
                                               const char* what);
  /// The value of a parameter as written, or its default.
  std::optional<schema::Value> EvaluateParameter(const scenario::ParameterKey& key);
  /// Converts the value of `expr` (convert.h); errors point at the chosen value of a sweep.
  std::optional<schema::Value> ConvertFor(const schema::Parameter& parameter,
                                          const schema::Value& value, const dsl::Expr& expr,
                                          const scenario::Scope& scope);
  /// Chooses the `index`th value of the sweep `call`, and of the sweeps zipped with it.
  void Choose(const dsl::Expr& call, std::size_t index);

  std::nullopt_t Error(const dsl::DiagnosticKind& kind, const text::Span& span, std::string message,
                       std::string help = {});

  const scenario::Scenario& scenario() const { return scenario_; }
  const names::Names& names() const { return names_; }
  const scenario::Layers& layers() const { return layers_; }
  Sweeps& sweeps() { return sweeps_; }
  dsl::Diagnostics& diagnostics() { return diagnostics_; }

 private:
  /// A let or a parameter under evaluation, and the location of its definition.
  /// `group`: of a parameter, whose node all groups share; otherwise empty.
  struct Node {
    const void* node;
    std::string group = {};
    bool operator==(const Node&) const = default;
  };
  struct Active {
    Node node;
    dsl::Name name;
  };

  std::optional<schema::Value> EvaluateUnchecked(const dsl::Expr& expr,
                                                 const scenario::Scope& scope);
  /// True for a word of the parameter being set, or of the language.
  bool IsWordHere(std::string_view word, const scenario::Scope& scope) const;
  std::optional<schema::Value> EvaluatePath(const dsl::Expr& expr, const scenario::Scope& scope);
  std::optional<schema::Value> EvaluateLet(const scenario::Placed<dsl::Let>& let);
  std::optional<schema::Value> EvaluateNamedParameter(const dsl::Expr& expr,
                                                      const scenario::ParameterKey& key);
  /// A number or a vector, m.
  std::optional<schema::Value> EvaluateMeasure(const dsl::Expr& expr,
                                               const names::BoxMeasure& measure);
  /// Evaluates the size, to find cycles through it; false after a diagnostic.
  bool EvaluateSizeOf(const std::string& group);
  /// The number of objects in all groups, at least 1.
  std::optional<schema::Value> CountObjects();
  /// True if the value, as written, is a layout that lists its objects: `at`, `poses`, `path`, or
  /// has as many as another group: `relative_to`.
  bool ListsPlaces(const dsl::Expr& expr, const scenario::Scope& scope);
  /// The number of objects that the group's layout lists; nullopt if it lists none, or after a
  /// diagnostic.
  std::optional<schema::Value> CountPlaces(const std::string& group);
  /// False, with a report, if `node`, written as `expr`, is already being evaluated.
  bool CheckCircle(const Node& node, const dsl::Expr& expr);

  const scenario::Scenario& scenario_;
  const scenario::Layers& layers_;
  dsl::Diagnostics& diagnostics_;
  names::Names names_;
  Sweeps sweeps_;
  std::map<const dsl::Let*, std::optional<schema::Value>> let_values_;  ///< at the current choice
  std::vector<Active> active_;                                          ///< the innermost one last
  bool is_chain_reported_ = false;
};

// Arithmetic on values.

class Evaluator;

/// `-a`; nullopt after a diagnostic.
std::optional<schema::Value> EvaluateNegation(const dsl::Expr& expr, const scenario::Scope& scope,
                                              Evaluator& evaluator);
/// `a + b`, `a - b`, `a * b`, `a / b`, `a ^ b`; nullopt after a diagnostic.
std::optional<schema::Value> EvaluateBinary(const dsl::Expr& expr, const scenario::Scope& scope,
                                            Evaluator& evaluator);

/// The SI unit of a parameter; that of a joint's depends on the joint's type, at the chosen point.
std::string_view UnitOf(const scenario::ParameterKey& key, Evaluator& evaluator);

// Functions of numbers: `round(1.5 * n)`, `sqrt(2)`.

class Evaluator;

/// `round floor ceil abs min max sqrt sin cos exp log`. They are not reserved: a let may have such
/// a name.
std::vector<std::string_view> FunctionNames();
bool IsFunction(std::string_view name);

/// The constant `pi`, unless a let has this name.
inline constexpr std::string_view kPiName = "pi";
inline constexpr double kPi = 3.141592653589793;

/// `round floor ceil` give integers, with halves rounded away from zero; `abs min max` of integers
/// are integers; the others give reals as rounded by the C library, which the plan then stores.
/// Values drawn for each object give a formula. Nullopt after a diagnostic.
std::optional<schema::Value> EvaluateFunction(const dsl::Expr& call, const scenario::Scope& scope,
                                              Evaluator& evaluator);

}  // namespace cdb::evaluate
