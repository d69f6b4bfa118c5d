// A syntax tree as text, for comparison: what was written, without places and brackets.
#pragma once

#include <string>

#include "dsl/syntax.h"

namespace cdb::dsl::testing {

/// `(range 1 5 step 2)`, `(call any (* sphere 3) cone as z)`, one statement a line.
std::string Dump(const File& file);
std::string Dump(const Expr& expr);
std::string Dump(const Condition& condition);

}  // namespace cdb::dsl::testing
