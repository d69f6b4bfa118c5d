// How many bodies a scene has, which is what detectors have limits for.
#pragma once

#include <cstdint>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// Objects of all groups, and the walls that stand.
std::uint64_t BodyCount(const plan::Scene& scene);
/// The most of any run.
std::uint64_t MaxBodyCount(const plan::Plan& plan);

}  // namespace cdb::analysis
