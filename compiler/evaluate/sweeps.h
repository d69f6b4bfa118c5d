// The sweeps of one `Layers`: their values, and the chosen value of each.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/value.h"

namespace cdb::evaluate {

class Evaluator;

/// The functions that make an axis.
inline constexpr std::string_view kSweep = "sweep", kFind = "find", kRace = "race";
inline bool MakesAxis(std::string_view function) {
  return function == kSweep || function == kFind || function == kRace;
}
/// True for a call of one of them.
inline bool IsSweep(const dsl::Expr& expr) {
  return expr.kind == dsl::ExprKind::kCall && MakesAxis(expr.text);
}
inline bool IsFind(const dsl::Expr& expr) {
  return expr.kind == dsl::ExprKind::kCall && expr.text == kFind;
}
inline bool IsRace(const dsl::Expr& expr) {
  return expr.kind == dsl::ExprKind::kCall && expr.text == kRace;
}
/// The argument of a `race( )` that is a figure, `by: mean(step)`.
inline constexpr std::string_view kBy = "by";

/// A call that makes an axis, with its ranges expanded.
struct Sweep {
  /// A value: an expression, or a number of a range.
  struct Item {
    const dsl::Expr* expr = nullptr;
    std::optional<schema::Number> number;
  };
  std::vector<Item> items;
  /// kSobol or kLatin if the items are such a range, otherwise nullopt; and its ends.
  std::optional<dsl::RangeKind> sampled = std::nullopt;
  std::pair<double, double> ends = {};
  bool is_log = false;      ///< the last range is logarithmic
  bool has_ladder = false;  ///< a range is divided by a tolerance
  double tolerance = 0;     ///< of a search or a race
};

/// How close together the values of a `find(a .. b)` are, unless its `tolerance` says so: a part of
/// the range, or, if it is logarithmic, of each value.
inline constexpr double kTolerance = 0.05;

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
  /// An argument with a name; false after a diagnostic.
  bool TakeNamed(const dsl::Expr& call, const dsl::Argument& argument, const scenario::Scope& scope,
                 Sweep& sweep);
  bool AddItems(const dsl::Expr& call, const dsl::Expr& expr, const scenario::Scope& scope,
                Sweep& sweep);
  bool AddSamples(const dsl::Expr& call, const dsl::Expr& range, const scenario::Scope& scope,
                  Sweep& sweep);

  Evaluator& evaluator_;
  std::map<const dsl::Expr*, std::optional<Sweep>> sweeps_;
  std::map<const dsl::Expr*, std::size_t> chosen_;
  bool is_inside_ = false;  ///< a value of a sweep is being evaluated
};

// The numbers of a range: `1 .. 5`, `0 .. 1 step 0.1`, `1 .. 1000 count 4 log`.

class Evaluator;

/// The maximum number of values on one axis.
inline constexpr std::size_t kMaxAxisValues = 1'000'000;

inline bool IsSampled(dsl::RangeKind kind) {
  return kind == dsl::RangeKind::kSobol || kind == dsl::RangeKind::kLatin;
}

/// Values between which a boundary is searched: 2^m equal parts of a range `a .. b`, or equal
/// ratios, so that a smaller tolerance keeps the values of a larger one. Nullopt after a
/// diagnostic.
std::optional<std::vector<schema::Number>> ExpandLadder(const dsl::Expr& range, double tolerance,
                                                        const scenario::Scope& scope,
                                                        Evaluator& evaluator);

/// Of a range that is not sampled. Nullopt after a diagnostic.
std::optional<std::vector<schema::Number>> ExpandRange(const dsl::Expr& range,
                                                       const scenario::Scope& scope,
                                                       Evaluator& evaluator);

/// The sampled range that is the `dimension`th of its zip, in the order of the points. Nullopt
/// after a diagnostic.
std::optional<Sweep> ExpandSamples(const dsl::Expr& range, std::size_t dimension,
                                   const scenario::Scope& scope, Evaluator& evaluator);

/// Rounds the numbers between the ends of a logarithmic range to integers, and removes duplicates:
/// a count cannot be 34.66.
void RoundBetweenEnds(std::vector<schema::Number>& numbers);

}  // namespace cdb::evaluate
