// Expressions to terms, for one choice of a value on every axis.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/evaluate/term.h"
#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::evaluate {

/// A `sweep( )` with its values counted out.
struct Sweep {
  /// A value: an expression, or what a range came to.
  struct Item {
    const dsl::Expr* expr = nullptr;
    std::optional<Number> number;
  };
  const dsl::Expr* call = nullptr;
  scenario::Scope scope;
  std::vector<Item> items;
};

/// What a name in an expression stands for.
struct Referent {
  std::optional<scenario::Placed<dsl::Let>> let;
  std::optional<scenario::ParameterKey> parameter;  ///< a parameter's name, set or not
};

/// Evaluates the expressions of one `Layers`. Every error is reported once and gives nullopt.
class Evaluator {
 public:
  Evaluator(const scenario::Scenario& scenario, const scenario::Layers& layers,
            dsl::Diagnostics& diagnostics);

  /// The value at the axes' present choice.
  std::optional<Term> Evaluate(const dsl::Expr& expr, const scenario::Scope& scope);
  /// A parameter's value as it is written, or its default.
  std::optional<Term> EvaluateParameter(const scenario::ParameterKey& key);
  /// A term of `expr` as `parameter` takes it; what is wrong is said of the choice in question.
  std::optional<schema::Value> ToValue(const Term& term, const schema::Parameter& parameter,
                                       const dsl::Expr& expr, const scenario::Scope& scope);
  /// Where the value of `expr` is written, as near as can be told.
  const dsl::Expr& Origin(const dsl::Expr& expr, const scenario::Scope& scope);
  bool Holds(const dsl::Condition& condition, const scenario::Scope& scope);

  /// The sweep at `call`, its ranges counted out at first use; null where that failed.
  const Sweep* FindSweep(const dsl::Expr& call, const scenario::Scope& scope);
  /// From now on `call` has its `index`th value.
  void Choose(const dsl::Expr& call, std::size_t index);

  /// What `path` means in `scope`; empty for a word.
  Referent Resolve(const std::string& path, const scenario::Scope& scope) const;

  /// A name that conditions know beside lets and parameters: an axis, and its value at this point.
  std::map<std::string, Term, std::less<>> axis_values;
  /// All values of the axes that have words among them: what a word in a condition can be.
  std::map<std::string, std::vector<std::string>, std::less<>> axis_words;

  dsl::Diagnostics& diagnostics() { return diagnostics_; }

 private:
  /// A let or a parameter that is being evaluated, and where it is set.
  struct Active {
    const void* node;
    dsl::Name name;
  };
  std::nullopt_t Circle(const void* node);
  std::optional<Term> EvaluatePath(const dsl::Expr& expr, const scenario::Scope& scope);
  std::optional<Term> EvaluateBinary(const dsl::Expr& expr, const scenario::Scope& scope);
  std::optional<Term> EvaluateCall(const dsl::Expr& expr, const scenario::Scope& scope);
  std::optional<Term> EvaluateDrawn(const dsl::Expr& expr, schema::DistributionKind kind,
                                    const scenario::Scope& scope);
  /// A word with its arguments.
  std::optional<Term> EvaluateWord(const dsl::Expr& expr, const schema::ParametrisedWord& info,
                                   const scenario::Scope& scope);
  /// Finds the file and its hash; `arguments` are as they were written.
  bool ReadNamed(schema::Call& call, const std::vector<Term>& arguments);
  /// What the text stands for behind `trace`.
  std::optional<schema::Call> TraceNamed(const Term& name);
  std::nullopt_t NoSuchFunction(const dsl::Expr& expr, const scenario::Scope& scope);
  std::optional<Term> EvaluateAny(const dsl::Expr& expr, const scenario::Scope& scope);
  std::optional<Eigen::Vector3d> EvaluateTriple(const dsl::Expr& expr, const scenario::Scope& scope,
                                                const char* what);
  std::optional<Number> EvaluateNumber(const dsl::Expr& expr, const scenario::Scope& scope,
                                       const char* what);
  /// One side of a comparison, `other` being its other side.
  std::optional<Term> Comparand(const dsl::Expr& expr, const dsl::Expr& other,
                                const scenario::Scope& scope);
  /// `word`, which is no name, can be what `other` is compared with.
  bool CheckWord(const dsl::Expr& word, const dsl::Expr& other, const scenario::Scope& scope);
  bool IsLiteralWord(const dsl::Expr& expr, const scenario::Scope& scope) const;
  /// What the axis or the parameter `expr` can be, as far as that is words.
  std::vector<std::string_view> WordsOf(const dsl::Expr& expr, const scenario::Scope& scope) const;
  /// Several words as one: `gravity, walls`.
  std::optional<Term> EvaluateList(const dsl::Setting& setting, const scenario::Scope& scope);
  bool ExpandRange(const dsl::Expr& range, const scenario::Scope& scope,
                   std::vector<Sweep::Item>& items);
  bool AddItems(const dsl::Expr& expr, const scenario::Scope& scope,
                std::vector<Sweep::Item>& items);
  bool Finite(const Term& term, const dsl::Span& span);
  /// A word stands where a number has to.
  std::nullopt_t NoSuchLet(const dsl::Span& span, const std::string& word,
                           const scenario::Scope& scope);
  std::nullopt_t Error(const dsl::DiagnosticKind& kind, const dsl::Span& span, std::string message,
                       std::string help = {});

  const scenario::Scenario& scenario_;
  const scenario::Layers& layers_;
  dsl::Diagnostics& diagnostics_;
  std::map<const dsl::Expr*, std::optional<Sweep>> sweeps_;
  std::map<const dsl::Expr*, std::size_t> chosen_;
  std::map<const dsl::Let*, std::optional<Term>> let_values_;  ///< at the present choice
  std::vector<Active> active_;                                 ///< the innermost last
  bool in_sweep_ = false;
};

/// At most so many values on one axis and so many runs in a plan.
inline constexpr std::size_t kMaxRuns = 100'000;

}  // namespace cdb::evaluate
