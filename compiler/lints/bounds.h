// Bounds of the values that a scene draws, without drawing them.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::lints {

struct Bounds {
  double least = 0, most = 0;
};

/// Bounds of a number: of a distribution its usual range (compiler/schema/cumulative.h), of any( )
/// its numbers. A lower bound of a distribution is at least a thousandth of `most`: few draws are
/// smaller. For same( ) and density( ), those of their value. {0, 0} if the value is a word or a
/// formula.
Bounds PositiveBounds(const schema::Value& value);

/// Bounds of a setting that may be a formula: the extremes of its values with each setting in it at
/// its smallest or its largest value, which `bounds_of` gives by name. {0, 0} if it names too many
/// settings.
Bounds PositiveBounds(const schema::Value& value,
                      const std::function<Bounds(std::string_view)>& bounds_of);

/// The largest absolute value of each component of a vector, or of a schedule in the course of a
/// run.
Eigen::Vector3d LargestComponents(const schema::Value& value);

/// True if the value is drawn or set by a schedule, not a constant.
bool IsDrawnOrScheduled(const schema::Value& value);

}  // namespace cdb::lints
