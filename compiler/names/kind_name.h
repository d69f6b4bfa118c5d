// The kind of a value, for messages.
#pragma once

#include <string>

#include "compiler/schema/value.h"

namespace cdb::names {

/// `the number 5`, `a vector`, `'sphere'`.
std::string KindName(const schema::Value& value);

}  // namespace cdb::names
