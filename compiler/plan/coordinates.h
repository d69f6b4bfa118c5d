// Coordinates on axes as people read them. Plans and results hold the numbers themselves.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::plan {

/// A value on an axis, in full if it is whole or has at most six significant digits: 0.0125. Others
/// are rounded to four digits, or to as many as tell them from all other values of the axis: 1/60
/// is 0.01667, 0.30000000000000004 is 0.3. Two different values never have the same label.
std::string CoordinateLabel(const Axis& axis, std::size_t index);

/// The labels of all values; faster than one by one.
std::vector<std::string> CoordinateLabels(const Axis& axis);

/// A number as CoordinateLabel writes it on an axis of its own.
std::string ShortReal(double value);

}  // namespace cdb::plan
