// Faults of a scene that the library finds before a run.
#pragma once

#include <cstdint>
#include <optional>

#include "compiler/analysis/scene_fault.h"

namespace cdb::closed_forms {

/// Finds numbers that the engine cannot hold, objects that cannot be placed, as far as `draws`
/// suffice for a crowded cube (library/layouts/placement.h), and violated conditions of the closed
/// form that the scene names. Scenes with models or mesh files are checked only for a closed form,
/// as decomposing a mesh takes seconds. Threads: any.
std::optional<analysis::SceneFault> FindSceneFault(const plan::Scene& scene, std::uint64_t& draws);

}  // namespace cdb::closed_forms
