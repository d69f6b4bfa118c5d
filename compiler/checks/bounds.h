// How small and how large what a scene draws can be, without drawing it.
#pragma once

#include <Eigen/Core>

#include "compiler/plan/plan.h"

namespace cdb::checks {

struct Bounds {
  double least = 0, most = 0;
};

/// Of a number: of a distribution its usual range (compiler/schema/cumulative.h), of any( ) its
/// numbers. What can only be more than 0 is at least a thousandth of `most`: few draws are less.
/// Of same( ) and density( ), of their value. {0, 0} where the value is a word.
Bounds PositiveBounds(const schema::Value& value);

/// Of a vector, or of what a schedule gives in the course of a run: the largest size of each
/// component.
Eigen::Vector3d LargestComponents(const schema::Value& value);

/// All values are drawn, or set by a schedule: not one constant.
bool IsDrawnOrScheduled(const schema::Value& value);

}  // namespace cdb::checks
