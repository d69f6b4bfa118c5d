// How many bodies a scene has, which is what detectors have limits for.
#pragma once

#include <cstdint>

#include "compiler/plan/plan.h"

namespace cdb::plan {

/// Objects of all groups, and the walls that stand.
std::uint64_t BodyCount(const Scene& scene);
/// The most of any run.
std::uint64_t MaxBodyCount(const Plan& plan);

}  // namespace cdb::plan
