// A syntax tree as text, without source positions and brackets, for comparison.
#pragma once

#include <string>

#include "dsl/syntax.h"

namespace cdb::tests {

/// For example `(range 1 5 step 2)`, `(call any (* sphere 3) cone as z)`; one statement per line.
std::string Dump(const dsl::File& file);
std::string Dump(const dsl::Expr& expr);
std::string Dump(const dsl::Condition& condition);

}  // namespace cdb::tests
