// The errors that a scene or a plan requests by `accuracy.metrics`.
#pragma once

#include <vector>

#include "compiler/plan/plan.h"
#include "compiler/schema/metrics.h"

namespace cdb::analysis {

/// In the order of the table; empty if the scene requests none.
std::vector<const schema::ErrorInfo*> ErrorsOf(const plan::Scene& scene);
/// Those of all runs together.
std::vector<const schema::ErrorInfo*> ErrorsOf(const plan::Plan& plan);

}  // namespace cdb::analysis
