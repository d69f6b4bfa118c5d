// The functions and operators of expressions, on numbers.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "compiler/schema/number.h"
#include "compiler/schema/schema.h"

namespace cdb::schema {

/// The units of the arguments that a function takes, and of its value.
enum class FunctionUnits {
  kNone,     ///< numbers without a unit
  kSame,     ///< all of one unit, that of the value
  kRoot,     ///< any unit; that of the value is its root
  kOfAngle,  ///< an angle, or none; the value has none
};

struct Function {
  std::string_view name;
  std::size_t most_arguments = 1;
  Number (*apply)(std::span<const Number>);  ///< at least one number; may give NaN or infinity
  Domain domain = {};                        ///< of the arguments
  FunctionUnits units = FunctionUnits::kNone;
};

/// `round floor ceil abs min max sqrt sin cos exp log`.
std::span<const Function> Functions();
/// Null if there is none with this name.
const Function* FindFunction(std::string_view name);

/// `op`: one of + - * / ^. A division by 0 gives NaN or infinity.
Number Calculate(char op, const Number& a, const Number& b);

}  // namespace cdb::schema
