#include "library/layouts/placement.h"

#include <algorithm>
#include <vector>

#include "library/layouts/bodies.h"
#include "library/layouts/clearance.h"
#include "library/layouts/drawn_layouts.h"
#include "library/layouts/exact_layouts.h"
#include "library/layouts/packing_fraction.h"

namespace cdb::layouts {
namespace {

/// Places the groups with exact layouts. False if there are no groups to be drawn.
bool PlaceStanding(const plan::Scene& scene, Bodies& bodies) {
  std::vector<std::uint32_t> standing;
  for (const GroupRange& range : bodies.groups()) {
    if (!HasExactLayout(*range.group)) continue;
    PlaceExactly(scene, range, bodies);
    for (std::size_t i = range.first; i < range.end; ++i)
      standing.push_back(static_cast<std::uint32_t>(i));
  }
  CheckClearance(bodies, standing);
  return standing.size() < bodies.size();
}

}  // namespace

void Place(const plan::Scene& scene, InitialState& state) {
  Bodies bodies(scene, state);
  if (PlaceStanding(scene, bodies)) PlaceDrawn(scene, bodies);
}

void CheckPlacement(const plan::Scene& scene) {
  InitialState state = DrawObjects(scene);
  Bodies bodies(scene, state);
  if (PlaceStanding(scene, bodies)) PackingFraction(bodies).RefuseWhatCannotFit();
}

}  // namespace cdb::layouts
