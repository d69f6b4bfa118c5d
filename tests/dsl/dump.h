// A syntax tree as text, for comparison, without source positions and brackets.
#pragma once

#include <string>

#include "dsl/syntax.h"

namespace cdb::tests {

/// `(range 1 5 step 2)`, `(call any (* sphere 3) cone as z)`, one statement a line.
std::string Dump(const dsl::File& file);
std::string Dump(const dsl::Expr& expr);
std::string Dump(const dsl::Condition& condition);

}  // namespace cdb::tests
