// The number of bodies in a scene, which detectors limit.
#pragma once

#include <cstdint>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// The objects of all groups, plus the walls in use.
std::uint64_t BodyCount(const plan::Scene& scene);
/// The largest number of bodies of any run.
std::uint64_t MaxBodyCount(const plan::Plan& plan);

}  // namespace cdb::analysis
