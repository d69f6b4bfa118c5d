// The sweeps of one `Layers`: their values, and the chosen value of each.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// A `sweep( )` with its ranges expanded.
struct Sweep {
  /// A value: an expression, or a number of a range.
  struct Item {
    const dsl::Expr* expr = nullptr;
    std::optional<schema::Number> number;
  };
  std::vector<Item> items;
};

class Sweeps {
 public:
  explicit Sweeps(Evaluator& evaluator) : evaluator_(evaluator) {}

  /// The sweep at `call`, expanded at first use; null if that failed.
  const Sweep* Find(const dsl::Expr& call, const scenario::Scope& scope);
  /// Chooses the `index`th value of `call`; false if it was already chosen.
  bool Choose(const dsl::Expr& call, std::size_t index);
  /// The chosen value of `call`.
  std::optional<schema::Value> Evaluate(const dsl::Expr& call, const scenario::Scope& scope);
  /// The expression that determines `expr`: for a sweep, its chosen item if that is an expression.
  const dsl::Expr& Origin(const dsl::Expr& expr, const scenario::Scope& scope);

 private:
  std::optional<Sweep> Expand(const dsl::Expr& call, const scenario::Scope& scope);
  bool AddItems(const dsl::Expr& expr, const scenario::Scope& scope,
                std::vector<Sweep::Item>& items);

  Evaluator& evaluator_;
  std::map<const dsl::Expr*, std::optional<Sweep>> sweeps_;
  std::map<const dsl::Expr*, std::size_t> chosen_;
  bool is_inside_ = false;  ///< a value of a sweep is being evaluated
};

}  // namespace cdb::evaluate
