// Number literals: their form and range.
#pragma once

#include <string_view>

#include "dsl/diagnostics.h"

namespace cdb::dsl {

/// False, with one report at `span`, if the lexeme is not a number of the language or does not fit
/// into 64 bits.
bool CheckNumber(std::string_view lexeme, const text::Span& span, Diagnostics& diagnostics);

}  // namespace cdb::dsl
