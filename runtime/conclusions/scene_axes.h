// The axes of a results file by what they change: the scene, or how it is simulated.
#pragma once

#include <cstddef>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::conclusions {

/// The axes whose values are other scenes, which no front should compare: parameters of objects and
/// of the world, and named cases.
std::vector<std::size_t> SceneAxes(const store::ResultFile& file);

}  // namespace cdb::conclusions
