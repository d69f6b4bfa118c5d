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

  /// Sets the value of axis `name`, which conditions find beside lets and parameters.
  void SetAxis(const std::string& name, schema::Value value);
  /// All values of an axis of words: what a word in a condition can be.
  void SetAxisWords(const std::string& name, std::vector<std::string> words);
  bool HasAxisWords(const std::string& name) const { return axis_words_.contains(name); }

  /// At the chosen point of the axes; false after a diagnostic.
  bool Hold(const dsl::Condition& condition, const scenario::Scope& scope);
  /// Reports what no condition can hold, whatever its names stand for.
  void CheckCalls(const dsl::Condition& condition);

 private:
  /// A comparison by `op`, which stands at `span`.
  bool Compare(const dsl::Expr& left, const std::string& op, const dsl::Expr& right,
               const text::Span& span, const scenario::Scope& scope);
  /// One side of a comparison, `other` being its other side.
  std::optional<schema::Value> Comparand(const dsl::Expr& expr, const dsl::Expr& other,
                                         const scenario::Scope& scope);
  /// `word`, which is no name, can be what `other` is compared with.
  bool RefuseCall(const dsl::Expr& expr);
  /// One of `words`; without any, an axis, a let or a parameter.
  std::string Nearest(std::string_view word, std::vector<std::string_view> words,
                      const scenario::Scope& scope) const;
  bool CheckWord(const dsl::Expr& word, const dsl::Expr& other, const scenario::Scope& scope);
  bool IsLiteralWord(const dsl::Expr& expr, const scenario::Scope& scope) const;
  /// The words that the axis or the parameter `expr` can be.
  std::vector<std::string_view> WordsOf(const dsl::Expr& expr, const scenario::Scope& scope) const;

  evaluate::Evaluator& evaluator_;
  std::map<std::string, schema::Value, std::less<>> axis_values_;
  std::map<std::string, std::vector<std::string>, std::less<>> axis_words_;
};

}  // namespace cdb::configure
