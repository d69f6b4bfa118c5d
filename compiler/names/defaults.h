// The schema's defaults as syntax, so that they are evaluated like user input.
#pragma once

#include "compiler/schema/schema.h"
#include "dsl/syntax.h"

namespace cdb::names {

/// The setting of the default. Parsed once; never null for a row of the schema (checked).
const dsl::Setting& DefaultSetting(const schema::Parameter& parameter);

}  // namespace cdb::names
