#include "library/layouts/placement.h"

#include <algorithm>
#include <vector>

#include "library/layouts/bodies.h"
#include "library/layouts/clearance.h"
#include "library/layouts/drawn_layouts.h"
#include "library/layouts/exact_layouts.h"

namespace cdb::layouts {

void Place(const plan::Scene& scene, InitialState& state) {
  Bodies bodies(scene, state);
  std::vector<std::uint32_t> standing;
  for (const GroupRange& range : bodies.groups()) {
    if (!HasExactLayout(*range.group)) continue;
    PlaceExactly(scene, range, bodies);
    for (std::size_t i = range.first; i < range.end; ++i)
      standing.push_back(static_cast<std::uint32_t>(i));
  }
  CheckClearance(bodies, standing);
  if (standing.size() < bodies.size()) PlaceDrawn(scene, bodies);
}

}  // namespace cdb::layouts
