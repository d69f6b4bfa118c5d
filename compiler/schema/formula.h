// Formulae: expressions of values that are drawn for an object, as a setting of the same group.
//
// They depend on one another without a circle, and name settings that are numbers.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/value.h"

namespace cdb::schema {

/// A formula has at most this many operators, functions, numbers and names.
inline constexpr std::size_t kMostFormulaParts = 200;
std::size_t FormulaParts(const Value& value);

/// `op` is an operator or a function, and takes so many arguments.
bool IsFormulaOp(std::string_view op, std::size_t arguments);

/// The names of settings in it, in order; a setting that is named twice is there twice.
/// They are parts of `value`.
std::vector<const Formula*> SettingsIn(const Value& value);
std::vector<const Formula*> SettingsIn(Value&& value) = delete;

/// As `.cdb` writes it, with no more brackets than it needs: `2 * size ^ 3`.
std::string FormulaText(const Formula& formula);

/// The value for an object of which `value_of` gives the settings by name. NaN or infinity where it
/// is no finite number.
double Evaluate(const Formula& formula, const std::function<double(std::string_view)>& value_of);

}  // namespace cdb::schema
