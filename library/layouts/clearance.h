// Checks that objects placed by a layout neither overlap nor leave the cube.
#pragma once

#include <cstdint>
#include <vector>

#include "library/layouts/bodies.h"

namespace cdb::layouts {

/// `indices`: the objects to look at. Those that move may reach neither through a wall of the cube,
/// whichever stand, nor into any other; they may touch both, to a few roundings of their
/// coordinates. Fixed ones may leave the cube and overlap one another, and those of groups with
/// `overlap` on may be in each other's place.
/// Throws SceneError, which names the object that comes later, the other or the wall, by how much,
/// and what to change. O(n) where sizes and shapes are alike.
void CheckClearance(const Bodies& bodies, const std::vector<std::uint32_t>& indices);

}  // namespace cdb::layouts
