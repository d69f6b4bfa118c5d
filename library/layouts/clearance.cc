#include "library/layouts/clearance.h"

#include <fmt/format.h>

#include <algorithm>

#include "library/layouts/exact_layouts.h"
#include "library/layouts/hash_grid.h"
#include "library/objects/distance.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

/// Below this part of what is looked at, two surfaces touch and do not overlap.
constexpr double kTouch = 1e-9;

const plan::Group& GroupOf(const Bodies& bodies, std::size_t index) {
  return *bodies.groups()[bodies.object(index).group].group;
}

void CheckWalls(const Bodies& bodies, std::size_t index) {
  const objects::Box box = bodies.BoxOf(index);
  const double half = bodies.side() / 2;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {-1, 1}) {
      const double through = (sign < 0 ? -box.lower[axis] : box.upper[axis]) - half;
      if (through < 0) continue;
      const std::string deed = through <= kTouch * bodies.side()
                                   ? "touches"
                                   : fmt::format("reaches {:.4g} m through", through);
      throw library::SceneError(fmt::format("{} {} the cube's wall {}{}; {}", bodies.Name(index),
                                            deed, sign < 0 ? '-' : '+', "xyz"[axis],
                                            AdviceOf(GroupOf(bodies, index)).wall));
    }
  }
}

/// How far `index` must go away from `other`, along the line between their centres of mass, to be
/// free of it. m.
double Depth(const Bodies& bodies, std::size_t index, std::size_t other) {
  const ObjectState &object = bodies.object(index), &neighbour = bodies.object(other);
  const Vector3d offset = object.pose.position - neighbour.pose.position;
  const double apart = offset.norm();
  const Vector3d direction = apart > 0 ? Vector3d(offset / apart) : Vector3d::UnitY();
  const double touch = kTouch * (object.solid.sides.norm() + neighbour.solid.sides.norm());
  const auto free = objects::Approach(neighbour.solid, neighbour.pose, object.solid, object.pose,
                                      direction, touch);
  return free.value_or(apart) - apart > 2 * touch ? *free - apart : 0;
}

[[noreturn]] void Overlapping(const Bodies& bodies, std::size_t a, std::size_t b) {
  const auto [other, index] = std::minmax(a, b);
  const double depth = Depth(bodies, index, other);
  const std::string deed =
      depth > 0
          ? fmt::format("overlaps {} by {:.4g} m along the line between their centres of mass",
                        bodies.Name(other), depth)
          : fmt::format("touches {}", bodies.Name(other));
  const std::string_view advice = bodies.object(index).group == bodies.object(other).group
                                      ? AdviceOf(GroupOf(bodies, index)).overlap
                                      : "give one of the two groups another place";
  throw library::SceneError(fmt::format("{} {}; {}", bodies.Name(index), deed, advice));
}

}  // namespace

void CheckClearance(const Bodies& bodies, const std::vector<std::uint32_t>& indices) {
  const auto is_fixed = [&](std::uint32_t index) { return bodies.object(index).IsFixed(); };
  std::vector<char> overlaps;  // by group
  for (const GroupRange& range : bodies.groups())
    overlaps.push_back(range.group->settings.On("overlap"));
  const auto may_overlap = [&](std::uint32_t index) {
    return overlaps[bodies.object(index).group] != 0;
  };
  std::vector<std::pair<int, std::uint32_t>> by_size;  // the largest first
  by_size.reserve(indices.size());
  for (const std::uint32_t index : indices) {
    if (!is_fixed(index)) CheckWalls(bodies, index);
    by_size.emplace_back(-HashGrid::LevelOf(bodies.Extents(index).maxCoeff()), index);
  }
  std::ranges::sort(by_size);
  HashGrid grid(indices.size());
  for (const auto& [level, index] : by_size) {
    const objects::Box box = bodies.BoxOf(index);
    grid.AnyOf(box, [&](std::uint32_t other) {
      if (is_fixed(index) && is_fixed(other)) return false;
      if (may_overlap(index) && may_overlap(other)) return false;
      if (bodies.TouchesAt(index, bodies.core(index).position, box, other))
        Overlapping(bodies, index, other);
      return false;
    });
    grid.Add(index, -level, box);
  }
}

}  // namespace cdb::layouts
