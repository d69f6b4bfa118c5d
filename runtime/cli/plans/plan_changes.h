// What was changed in a scenario between two of its plans, for messages.
#pragma once

#include <string>

#include "compiler/plan/plan.h"

namespace cdb::plans {

/// `objects.quantity 100 -> 200, detector + sap, repeats 3 -> 5`: the values of parameters, over
/// all runs, that only one of the plans has; at most four parameters, and the number of the others.
/// `other runs` if the plans differ in nothing that has a name.
std::string DescribeChanges(const plan::Plan& before, const plan::Plan& now);

}  // namespace cdb::plans
