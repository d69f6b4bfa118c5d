// The schema's defaults as syntax, so that they are evaluated like anything a user writes.
#pragma once

#include "dsl/syntax.h"

namespace cdb::compiler {

struct Parameter;

/// The default's setting. Parsed once; never null for a row of the schema (checked).
const dsl::Setting& DefaultSetting(const Parameter& parameter);

}  // namespace cdb::compiler
