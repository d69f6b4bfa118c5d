// Divides the axes of a results file into those of the scene and those of its simulation.
#pragma once

#include <cstddef>
#include <vector>

#include "runtime/store/store.h"

namespace cdb::conclusions {

/// The axes whose values are different scenes, which must not share a front: parameters of objects
/// and of the world, and named cases.
std::vector<std::size_t> SceneAxes(const store::ResultFile& file);

}  // namespace cdb::conclusions
