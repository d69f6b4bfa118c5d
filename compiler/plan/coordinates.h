// Coordinates on axes as readable text. Plans and results hold the numbers themselves.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::plan {

/// A value on an axis, in full if it is an integer or has at most six significant digits: 0.0125.
/// Other values are rounded to four digits, or to the number that distinguishes them from all other
/// values of the axis: 1/60 is 0.01667, 0.30000000000000004 is 0.3. Two different values never have
/// the same label.
std::string CoordinateLabel(const Axis& axis, std::size_t index);

/// The labels of all values; faster than separate calls.
std::vector<std::string> CoordinateLabels(const Axis& axis);

/// A number as CoordinateLabel formats it on an axis with no other value.
std::string ShortReal(double value);

}  // namespace cdb::plan
