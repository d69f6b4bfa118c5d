// Formulae: expressions of values drawn for an object, in a setting of the same group.
//
// They have no circular dependencies, and name settings that are numbers.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/number.h"
#include "compiler/schema/schema.h"
#include "compiler/schema/value.h"

namespace cdb::schema {

/// The maximum number of operators, functions, numbers and names in a formula.
inline constexpr std::size_t kMostFormulaParts = 200;
std::size_t FormulaParts(const Value& value);

/// True if `op` is an operator or a function with this number of arguments.
bool IsFormulaOp(std::string_view op, std::size_t arguments);

/// The names of settings in it, in order; a setting named twice appears twice. They are parts of
/// `value`.
std::vector<const Formula*> SettingsIn(const Value& value);
std::vector<const Formula*> SettingsIn(Value&& value) = delete;

/// As written in `.cdb`, with the minimum of brackets: `2 * size ^ 3`.
std::string FormulaText(const Formula& formula);

/// A formula to be evaluated many times. Not thread-safe.
class FormulaProgram {
 public:
  /// `value`: a number or a formula; `names`: of its settings or variables, all of them.
  FormulaProgram(const Value& value, std::span<const std::string_view> names);
  /// For the values of the names, in their order. NaN or infinity if it is not a finite number.
  double operator()(std::span<const double> values);

 private:
  /// Takes its operands from the top of the stack, and puts its result there.
  struct Step {
    enum class Kind { kNumber, kName, kFunction, kOperator, kNegation } kind;
    double number = 0;      ///< of a kNumber
    std::size_t count = 0;  ///< the place of a name, or the number of operands
    Number (*apply)(std::span<const Number>) = nullptr;
    char op = 0;
  };

  void Add(const Value& value, std::span<const std::string_view> names);

  std::vector<Step> steps_;
  std::vector<Number> stack_;
};

/// The value for an object, whose settings `value_of` gives by name. NaN or infinity if it is not a
/// finite number.
double Evaluate(const Formula& formula, const std::function<double(std::string_view)>& value_of);

// The functions and operators of expressions, on numbers.

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
