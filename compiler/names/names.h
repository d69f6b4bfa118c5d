// The names in the expressions of one `Layers`.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/scenario/layers.h"

namespace cdb::names {

/// The meaning of a name in an expression.
struct Referent {
  std::optional<scenario::Placed<dsl::Let>> let;
  std::optional<scenario::ParameterKey> parameter;  ///< a parameter's name, set or not
  bool is_object_count = false;                     ///< `objects` in a default of the schema

  bool IsWord() const { return !let && !parameter && !is_object_count; }
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
  bool IsGroup(std::string_view name) const;

  const scenario::Scenario& scenario_;
  const scenario::Layers& layers_;
};

}  // namespace cdb::names
