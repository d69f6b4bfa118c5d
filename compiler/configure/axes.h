// Finds the sweeps of a benchmark and makes axes from them.
#pragma once

#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "compiler/evaluate/evaluate.h"
#include "compiler/plan/plan.h"
#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/value.h"

namespace cdb::configure {

/// One sweep of one `Layers`, as an axis.
struct SweepAxis {
  std::string name;
  text::Span span;
  const dsl::Expr* call = nullptr;
  std::string parameter, unit;
  std::string title = {};                     ///< may be empty
  std::optional<scenario::ParameterKey> key;  ///< of that parameter
  /// The argument of a word that contains the sweep, `ring(radius: sweep(1, 2))`; otherwise null.
  const schema::ParametrisedWord* word = nullptr;
  const schema::Parameter* argument = nullptr;
  int component = -1;         ///< 0, 1, 2: the sweep is in a vector or a ratio
  std::pair<int, int> order;  ///< of its statement, and its position in it
  std::vector<plan::Coordinate> values;
  std::vector<plan::Coordinates> sampled = {};  ///< of a zip of sampled ranges
  scenario::Scope scope = {};                   ///< of the call
  bool is_log = false;                          ///< of a `find( )` in a logarithmic range
};

/// The maximum number of runs of a benchmark.
inline constexpr double kMostRuns = 1e8;

/// All axes of `layers`, in the order in which the sweeps are written. Two axes of one name are
/// reported, and so are more points than kMostRuns if no `skip` can leave any out.
std::vector<SweepAxis> FindAxes(const scenario::Layers& layers, evaluate::Evaluator& evaluator);

/// A number, or the label of any other value.
plan::Coordinate CoordinateOf(const schema::Value& value);

// The sweeps that a value depends on.

/// All calls of `sweep` that the value of `expr` depends on, also through lets and parameters; of a
/// zip, the first.
std::set<const dsl::Expr*> SweepsIn(const dsl::Expr& expr, const scenario::Scope& scope,
                                    const scenario::Layers& layers,
                                    const evaluate::Evaluator& evaluator);

/// Of each of `keys`, indices into `axes` of those that its values depend on, also through lets and
/// other parameters.
std::vector<std::vector<std::size_t>> Dependencies(std::span<const scenario::ParameterKey> keys,
                                                   const scenario::Layers& layers,
                                                   const std::vector<SweepAxis>& axes,
                                                   const evaluate::Evaluator& evaluator);

}  // namespace cdb::configure
