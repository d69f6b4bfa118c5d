// Faults that the library finds in a scene before it runs.
#pragma once

#include <optional>

#include "compiler/analysis/scene_fault.h"

namespace cdb::closed_forms {

/// Objects that cannot be placed without a place being drawn (layouts/placement.h), or conditions
/// of the closed form that the scene names and does not meet. Scenes with models or mesh files are
/// looked at only for a closed form, as decomposing a mesh takes seconds. Threads: any.
std::optional<analysis::SceneFault> FindSceneFault(const plan::Scene& scene);

}  // namespace cdb::closed_forms
