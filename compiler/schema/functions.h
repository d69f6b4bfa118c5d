// The functions and operators of expressions, on numbers.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "compiler/schema/number.h"
#include "compiler/schema/schema.h"

namespace cdb::schema {

/// The units that a function takes and gives.
enum class UnitRule {
  kNone,   ///< takes and gives a number without a unit
  kSame,   ///< gives the unit of its arguments
  kAngle,  ///< takes an angle
  kRoot,   ///< gives the root of the unit of its argument
};

struct Function {
  std::string_view name;
  std::size_t most_arguments = 1;
  Number (*apply)(std::span<const Number>);  ///< at least one number; may give NaN or infinity
  UnitRule units = UnitRule::kNone;
  Domain domain = {};  ///< of the argument
};

/// `round floor ceil abs min max sqrt sin cos exp log`.
std::span<const Function> Functions();
/// Null if there is none with this name.
const Function* FindFunction(std::string_view name);

/// `op`: one of + - * / ^. A division by 0 gives NaN or infinity.
Number Calculate(char op, const Number& a, const Number& b);

}  // namespace cdb::schema
