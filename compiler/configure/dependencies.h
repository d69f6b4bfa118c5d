// The sweeps that a value depends on.
#pragma once

#include <cstddef>
#include <set>
#include <vector>

#include "compiler/configure/axes.h"
#include "compiler/evaluate/evaluate.h"
#include "compiler/scenario/layers.h"

namespace cdb::configure {

/// All calls of `sweep` that the value of `expr` depends on, also through lets and parameters; of a
/// zip, the first.
std::set<const dsl::Expr*> SweepsIn(const dsl::Expr& expr, const scenario::Scope& scope,
                                    const scenario::Layers& layers,
                                    const evaluate::Evaluator& evaluator);

/// Indices into `axes` of those that the values of `key` depend on, also through lets and other
/// parameters.
std::vector<std::size_t> Dependencies(const scenario::ParameterKey& key,
                                      const scenario::Layers& layers,
                                      const std::vector<SweepAxis>& axes,
                                      const evaluate::Evaluator& evaluator);

}  // namespace cdb::configure
