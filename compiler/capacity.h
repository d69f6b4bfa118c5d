// How many bodies a scene has, which is what detectors have limits for.
#pragma once

#include <cstdint>

#include "compiler/plan.h"

namespace cdb::compiler {

/// Objects of all groups, and the walls that stand.
std::uint64_t BodyCount(const Scene& scene);

}  // namespace cdb::compiler
