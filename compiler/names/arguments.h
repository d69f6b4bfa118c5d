// Matches the arguments of a parametrised word with its row in
// compiler/schema/parametrised_words.h.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/diagnostics.h"
#include "dsl/syntax.h"

namespace cdb::names {

/// The argument of the row that the `i`th argument of `call` sets, by name or by position; null if
/// `info` has no such argument.
const schema::Parameter* ArgumentAt(const schema::ParametrisedWord& info, const dsl::Expr& call,
                                    std::size_t i);

/// The scope of the `i`th argument of `call`, which is itself in `scope`: `fit` is a word of the
/// argument, not a name.
scenario::Scope ArgumentScope(const dsl::Expr& call, std::size_t i, const scenario::Scope& scope);

/// The arguments of a call, in the order of the row. Reports arguments that do not match.
class GivenArguments {
 public:
  GivenArguments(const dsl::Expr& call, const schema::ParametrisedWord& info,
                 dsl::Diagnostics& diagnostics);

  bool good() const { return good_; }
  /// Null if the call does not give it.
  const dsl::Argument* operator[](std::size_t i) const { return given_[i]; }

 private:
  void Report(const text::Span& span, std::string message, std::string help = {});
  void ReportWeight(const dsl::Argument& argument);
  void ReportNoSuch(const dsl::Argument& argument);
  void Take(const dsl::Argument& argument, const schema::Parameter& slot);

  const schema::ParametrisedWord& info_;
  dsl::Diagnostics& diagnostics_;
  std::vector<const dsl::Argument*> given_;
  bool good_ = true;
};

}  // namespace cdb::names
