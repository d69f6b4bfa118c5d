// How small and how large what a scene draws can be, without drawing it.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string_view>

#include "compiler/plan/plan.h"

namespace cdb::lints {

struct Bounds {
  double least = 0, most = 0;
};

/// Of a number: of a distribution its usual range (compiler/schema/cumulative.h), of any( ) its
/// numbers. What can only be more than 0 is at least a thousandth of `most`: few draws are less.
/// Of same( ) and density( ), of their value. {0, 0} where the value is a word, or a formula.
Bounds PositiveBounds(const schema::Value& value);

/// The same of a setting that may be a formula: between its values where each setting that it names
/// is as small, or as large, as it can be. `bounds_of` gives these by name. {0, 0} where it names
/// more than a few.
Bounds PositiveBounds(const schema::Value& value,
                      const std::function<Bounds(std::string_view)>& bounds_of);

/// Of a vector, or of what a schedule gives in the course of a run: the largest size of each
/// component.
Eigen::Vector3d LargestComponents(const schema::Value& value);

/// All values are drawn, or set by a schedule: not one constant.
bool IsDrawnOrScheduled(const schema::Value& value);

}  // namespace cdb::lints
