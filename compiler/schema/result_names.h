// THE table of the names in a results file that an axis may not have: an axis is a variable of the
// same file, and is never renamed. The checker and the store read it; a test compares it with the
// layout of the file.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/metrics.h"

namespace cdb::schema {

/// Names of the same kind.
struct ResultNames {
  std::string_view kind;  ///< a noun for one of them: `a series of the results`
  std::vector<std::string_view> names;
  bool only_with_errors = false;  ///< in the file only if the benchmark asks for errors
};
const std::vector<ResultNames>& ReservedNames();

/// The kind of the existing name that equals `axis` in the results of a benchmark that requests
/// `errors`: `a series of the results`. Nullopt if the name is free.
std::optional<std::string> FindNameClash(std::string_view axis,
                                         std::span<const ErrorInfo* const> errors);

}  // namespace cdb::schema
