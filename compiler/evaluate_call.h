// How the arguments of a word are matched with its row in compiler/calls.h.
#pragma once

#include <cstddef>

#include "compiler/calls.h"
#include "compiler/layers.h"
#include "dsl/syntax.h"

namespace cdb::compiler {

/// What the `i`th argument of `call` stands for, by its name or by its place; null where `info` has
/// no such argument.
const Parameter* ArgumentAt(const CallInfo& info, const dsl::Expr& call, std::size_t i);

/// Where the `i`th argument of `call`, itself written in `scope`, is evaluated: `fit` is a word of
/// the argument, not a name.
Scope ArgumentScope(const dsl::Expr& call, std::size_t i, const Scope& scope);

}  // namespace cdb::compiler
