// How the arguments of a word are matched with its row in compiler/calls.h.
#pragma once

#include <cstddef>

#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/syntax.h"

namespace cdb::evaluate {

/// What the `i`th argument of `call` stands for, by its name or by its place; null where `info` has
/// no such argument.
const schema::Parameter* ArgumentAt(const schema::ParametrisedWord& info, const dsl::Expr& call,
                                    std::size_t i);

/// Where the `i`th argument of `call`, itself written in `scope`, is evaluated: `fit` is a word of
/// the argument, not a name.
scenario::Scope ArgumentScope(const dsl::Expr& call, std::size_t i, const scenario::Scope& scope);

}  // namespace cdb::evaluate
