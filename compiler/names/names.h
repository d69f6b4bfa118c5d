// The names in the expressions of one `Layers`.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/scenario/layers.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"
#include "dsl/diagnostics.h"
#include "dsl/syntax.h"

namespace cdb::names {

/// A measure of the box around an object of a group: `part.extent`, `part.lower.y`.
struct BoxMeasure {
  enum class Kind {
    kExtent,  ///< the sides
    kLower,   ///< the corners, from the point that a layout places
    kUpper,
  };
  /// The parameters that determine the box.
  static constexpr schema::GroupParameter kOf[] = {"type", "size", "aspect"};

  std::string group;
  Kind kind = Kind::kExtent;
  std::optional<int> axis;  ///< nullopt: a vector
};

/// The meaning of a name in an expression.
struct Referent {
  std::optional<scenario::Placed<dsl::Let>> let;
  std::optional<scenario::ParameterKey> parameter;  ///< a parameter's name, set or not
  bool is_object_count = false;                     ///< `objects` in a default of the schema
  std::optional<BoxMeasure> measure = {};

  bool IsWord() const { return !let && !parameter && !is_object_count && !measure; }
};

class Names {
 public:
  Names(const scenario::Scenario& scenario, const scenario::Layers& layers)
      : scenario_(scenario), layers_(layers) {}

  /// A let or a parameter, searched for from the innermost block outwards; otherwise `path` is a
  /// word.
  Referent Resolve(const std::string& path, const scenario::Scope& scope) const;
  /// The let with the name nearest to `word`; empty if none is near.
  std::string_view NearestLet(const std::string& word, const scenario::Scope& scope) const;

 private:
  std::optional<scenario::Placed<dsl::Let>> FindLet(const std::string& path,
                                                    const scenario::Scope& scope) const;
  std::optional<scenario::ParameterKey> FindParameter(const std::string& path,
                                                      const scenario::Scope& scope) const;
  std::optional<BoxMeasure> FindMeasure(std::string_view path, const scenario::Scope& scope) const;
  bool IsGroup(std::string_view name) const;

  const scenario::Scenario& scenario_;
  const scenario::Layers& layers_;
};

// Matches the arguments of a parametrised word with its row in
// compiler/schema/parametrised_words.h.

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

// The schema's defaults as syntax, so that they are evaluated like user input.

/// The setting of the default. Parsed once; never null for a row of the schema (checked).
const dsl::Setting& DefaultSetting(const schema::Parameter& parameter);

// The kind of a value, for messages.

/// `the number 5`, `a vector`, `'sphere'`.
std::string KindName(const schema::Value& value);

}  // namespace cdb::names
