// Random layouts, which redraw each position until it is free: uniform, normal.
#pragma once

#include "compiler/plan/plan.h"
#include "library/layouts/bodies.h"

namespace cdb::layouts {

/// Places the objects of all groups with such layouts, in order, around the objects already placed:
/// all those of exact layouts, inside the cube or not. Positions, errors:
/// library/layouts/placement.h.
void PlaceDrawn(const plan::Scene& scene, Bodies& bodies);

}  // namespace cdb::layouts
