// Checks that objects placed by a layout neither overlap nor leave the cube.
#pragma once

#include <cstdint>
#include <vector>

#include "library/layouts/bodies.h"

namespace cdb::layouts {

/// `indices`: the objects to check. Movable objects must neither reach through a wall of the cube,
/// whichever walls are in use, nor into another object; they may touch both, within a few roundings
/// of their coordinates. Fixed objects may leave the cube and overlap one another, and objects of
/// groups with `overlap` on may overlap each other. Throws SceneError, which names the later
/// object, the other object or the wall, the depth, and a remedy. O(n) if sizes and shapes are
/// similar.
void CheckClearance(const Bodies& bodies, const std::vector<std::uint32_t>& indices);

}  // namespace cdb::layouts
