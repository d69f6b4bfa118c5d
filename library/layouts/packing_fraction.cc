#include "library/layouts/packing_fraction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "library/layouts/exact_layouts.h"
#include "library/layouts/placement.h"
#include "library/scene_error.h"

namespace cdb::layouts {

using Eigen::Vector3d;

PackingFraction::PackingFraction(const Bodies& bodies) : bodies_(bodies) {
  for (const GroupRange& range : bodies.groups()) {
    const bool stands = HasExactLayout(*range.group);
    for (std::size_t i = range.first; i < range.end; ++i) {
      const objects::Solid& solid = bodies.object(i).solid;
      if (solid.IsSurface()) continue;  // it has no volume
      const double part = stands ? PartInside(i) : 1;
      const double volume = part * solid.Volume(), box = part * bodies.Extents(i).prod();
      volume_ += volume;
      if (stands) placed_volume_ += volume;
      boxes_ += box;
      balls_and_boxes_ += solid.IsBall() ? volume : box;
    }
  }
}

double PackingFraction::PartInside(std::size_t index) const {
  const objects::Box box = bodies_.BoxOf(index);
  const Vector3d half = Vector3d::Constant(bodies_.side() / 2);
  const Vector3d inside = box.upper.cwiseMin(half) - box.lower.cwiseMax(-half);
  return inside.cwiseMax(0).cwiseQuotient(box.upper - box.lower).prod();
}

void PackingFraction::RefuseWhatCannotFit() const {
  for (const GroupRange& range : bodies_.groups()) {
    if (HasExactLayout(*range.group)) continue;
    for (std::size_t i = range.first; i < range.end; ++i) RefuseLarge(i);
  }
  if (volume_ / Cube() > 1) {
    throw library::SceneError(
        fmt::format("all objects together would fill {:.4g} % of the cube, so none was placed",
                    100 * volume_ / Cube()),
        Advice());
  }
  for (const GroupRange& range : bodies_.groups())
    if (!HasExactLayout(*range.group)) RefuseGroup(range);
}

void PackingFraction::RefuseLarge(std::size_t index) const {
  // Computed in the same way as the domain of drawn positions.
  const objects::Box& box = bodies_.bounds(index);
  for (int axis = 0; axis < 3; ++axis) {
    if (-bodies_.side() / 2 - box.lower[axis] < bodies_.side() / 2 - box.upper[axis]) continue;
    throw library::SceneError(
        fmt::format("{} is {:.6g} m long along {} and does not fit between walls {:.6g} m apart",
                    bodies_.Name(index), box.upper[axis] - box.lower[axis], "xyz"[axis],
                    bodies_.side()),
        "make world.side larger or the size smaller", bodies_.GroupOf(index).name);
  }
}

void PackingFraction::RefuseGroup(const GroupRange& range) const {
  if (range.size() < kManyObjects) return;
  const objects::Solid& solid = bodies_.object(range.first).solid;
  for (std::size_t i = range.first; i < range.end; ++i) {
    if (bodies_.object(i).solid != solid) return;
    if (bodies_.Extents(i).maxCoeff() > kShortOfSide * bodies_.side()) return;
  }
  const double most = solid.IsBall() ? kMaxFillOfBalls : kMaxFillOfOthers;
  const double fill = static_cast<double>(range.size()) * solid.Volume() / Cube();
  if (fill <= most) return;
  throw library::SceneError(
      fmt::format("the {} objects of group `{}` fill {:.3g} % of the cube: equal objects at random "
                  "positions leave no free position before {:.3g} %, so none was placed",
                  range.size(), range.group->name, 100 * fill, 100 * most),
      Advice(), range.group->name);
}

std::string PackingFraction::Advice() const {
  // Boxes that fill a tenth of the cube leave enough space for random placement, whatever the
  // shapes.
  return fmt::format(
      "make world.side larger ({:.4g} m is enough), or the size or the quantity smaller",
      std::max(bodies_.side() * 1.1, std::cbrt(boxes_ * 10)));
}

void PackingFraction::TooFull(std::size_t index, std::string_view when) const {
  throw library::SceneError(
      fmt::format(
          "no free position was found for {}: all objects together fill {:.3g} % of the cube "
          "({:.3g} % with the boxes around them), {:.3g} % was filled when {}",
          bodies_.Name(index), 100 * volume_ / Cube(), 100 * boxes_ / Cube(),
          100 * placed_volume_ / Cube(), when),
      Advice(), bodies_.GroupOf(index).name);
}

}  // namespace cdb::layouts
