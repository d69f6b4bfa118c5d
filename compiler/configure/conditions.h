// Conditions: `skip when detector == sap and quantity > 100`.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/evaluate/evaluate.h"

namespace cdb::configure {

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

}  // namespace cdb::configure
