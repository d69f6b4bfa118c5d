// Lints about kinematic objects, which do not yield.

#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/lints/lint_facts.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

// By geometry.
constexpr double kCrush = 1;

/// An upright box, and the bounds of its displacement in a run.
struct Jaw {
  Vector3d at, half;
  Vector3d least = Vector3d::Zero(), most = Vector3d::Zero();
  bool is_on_path = false;  ///< else it moves in one direction
};

/// Nullopt for objects that yield, or whose place is not known.
std::optional<Jaw> JawOf(const SceneFacts& scene, const GroupFacts& objects) {
  if (objects.moves || objects.is_surface) return std::nullopt;
  const auto turn = ConstantOf(objects.settings->Get("orientation"));
  if (!turn || !turn->isZero(0)) return std::nullopt;
  const Vector3d half = objects.most_sides / 2;
  if (objects.path)
    return Jaw{objects.path->least, half, Vector3d::Zero(),
               objects.path->most - objects.path->least, true};
  if (objects.places.size() != 1) return std::nullopt;
  Jaw jaw{objects.places[0], half};
  if (!objects.is_kinematic) return jaw;
  const auto velocity = ConstantOf(objects.settings->Get("linear_velocity"));
  if (!velocity) return std::nullopt;
  jaw.least = (*velocity * scene.Time()).cwiseMin(Vector3d::Zero());
  jaw.most = (*velocity * scene.Time()).cwiseMax(Vector3d::Zero());
  return jaw;
}

/// Two jaws along one axis; `upper` is at larger coordinates.
struct Gap {
  int axis;
  double widest, closed;  ///< m, at most and by how much it closes
  Vector3d least, most;   ///< of the space between them
  bool is_on_path;        ///< so that the order of opening and closing is not known
};

/// The gap between two jaws that face each other along the axis.
std::optional<Gap> GapBetween(const Jaw& lower, const Jaw& upper, int axis) {
  const double bottom = lower.at[axis] + lower.half[axis];
  const double top = upper.at[axis] - upper.half[axis];
  const double widest = top + upper.most[axis] - (bottom + lower.least[axis]);
  const double least = top + upper.least[axis] - (bottom + lower.most[axis]);
  // On a path, the gap may close after it has opened.
  const bool only_opens =
      !lower.is_on_path && !upper.is_on_path &&
      upper.least[axis] + upper.most[axis] >= lower.least[axis] + lower.most[axis];
  if (only_opens || !(widest > 0) || !(widest > least)) return std::nullopt;
  Gap gap{axis,
          widest,
          widest - least,
          (lower.at + lower.least - lower.half).cwiseMax(upper.at + upper.least - upper.half),
          (lower.at + lower.most + lower.half).cwiseMin(upper.at + upper.most + upper.half),
          lower.is_on_path || upper.is_on_path};
  gap.least[axis] = bottom + lower.least[axis];
  gap.most[axis] = top + upper.most[axis];
  if ((gap.least.array() >= gap.most.array()).any()) return std::nullopt;
  return gap;
}

/// The walls of the cube, as thick boxes beyond it.
std::vector<Jaw> WallsOf(const SceneFacts& scene) {
  std::vector<Jaw> walls;
  if (!scene.has_walls) return walls;
  const bool is_floor = scene.world->WordOr("world.walls") == "floor";
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      if (is_floor && (axis != 1 || sign > 0)) continue;
      Jaw wall{Vector3d::Zero(), Vector3d::Constant(1.5 * scene.side)};
      wall.at[axis] = sign * 2 * scene.side;
      walls.push_back(wall);
    }
  return walls;
}

/// The worst gap so far for the objects of a group.
class Press {
 public:
  Press(const SceneFacts& scene, const GroupFacts& objects) : scene_(scene), objects_(objects) {}

  void Add(const Jaw& a, const Jaw& b) {
    for (int axis = 0; axis < 3; ++axis)
      for (const auto& gap : {GapBetween(a, b, axis), GapBetween(b, a, axis)})
        if (gap) Add(*gap);
  }
  const std::optional<Estimate>& worst() const { return worst_; }

 private:
  void Add(const Gap& gap) {
    const double room = gap.widest - objects_.least_side;
    if (!(room > 0)) return;
    const bool is_between = std::ranges::any_of(objects_.places, [&](const Vector3d& place) {
      return (place.array() > gap.least.array()).all() && (place.array() < gap.most.array()).all();
    });
    // Objects that begin elsewhere may come between, unless nothing moves them.
    const bool stays = !objects_.places.empty() && !(scene_.g > 0) && !(objects_.speed > 0);
    if (!is_between && stays) return;
    const double value = gap.closed / room;
    if (!worst_ || value > worst_->value)
      worst_ = Estimate{value, kCrush, room * Harmless(kCrush), !is_between || gap.is_on_path};
  }

  const SceneFacts& scene_;
  const GroupFacts& objects_;
  std::optional<Estimate> worst_;
};

}  // namespace

std::optional<Estimate> Crush(const SceneFacts& scene, const GroupFacts& objects) {
  if (std::ranges::none_of(scene.groups, &GroupFacts::is_kinematic)) return std::nullopt;
  const bool meets_walls = scene.collisions->MayTouchWalls(objects.index);
  Press press(scene, objects);
  for (const GroupFacts& moving : scene.groups) {
    if (!moving.is_kinematic || !scene.collisions->MayTouch(objects.index, moving.index)) continue;
    const auto jaw = JawOf(scene, moving);
    if (!jaw) continue;
    if (meets_walls)
      for (const Jaw& wall : WallsOf(scene)) press.Add(*jaw, wall);
    for (const GroupFacts& other : scene.groups)
      if (other.index != moving.index && scene.collisions->MayTouch(objects.index, other.index))
        if (const auto against = JawOf(scene, other)) press.Add(*jaw, *against);
  }
  return press.worst();
}

}  // namespace cdb::lints
