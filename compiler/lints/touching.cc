// Which objects touch others, as far as their settings tell: listed objects that stand on each
// other, and objects that meet in flight.
#include <algorithm>
#include <cmath>

#include "compiler/lints/lint_facts.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

/// Pairs of objects that are compared for a pair of groups; if there are more, they may meet.
constexpr std::size_t kMostPairs = 10'000;

/// Objects that move as if nothing touched them.
struct Flight {
  std::vector<Vector3d> places;  ///< at the start
  Vector3d velocity, acceleration;
  Vector3d reach;  ///< half of the sides of a box that holds an object however it turns
};

/// Half of the sides of an upright box about the centre of mass.
Vector3d ReachOf(const GroupFacts& objects) {
  const schema::Value& type = objects.settings->Get("type");
  if (MayBe(type, "sphere") && objects.least_sides == objects.most_sides &&
      objects.elongation == 1 && !std::holds_alternative<schema::Distribution>(type))
    return objects.most_sides / 2;
  const bool is_symmetric = std::ranges::any_of(
      std::initializer_list<const char*>{"cuboid", "cylinder", "capsule"}, [&](const char* name) {
        const schema::Word* word = schema::AsWord(type);
        return word != nullptr && word->text == name;
      });
  const Vector3d half = is_symmetric ? objects.most_sides / 2 : Vector3d(objects.most_sides);
  const auto turn = ConstantOf(objects.settings->Get("orientation"));
  const bool is_upright = turn && turn->isZero(0) && !(objects.spin > 0) && !objects.path;
  return is_upright ? half : Vector3d::Constant(half.norm());
}

/// Nullopt if the motion is not known.
std::optional<Flight> FlightOf(const SceneFacts& scene, const GroupFacts& objects) {
  if (objects.linked || BoundsOf(*objects.settings, "linear_damping").most > 0) return std::nullopt;
  Flight flight{objects.places, Vector3d::Zero(), Vector3d::Zero(), ReachOf(objects)};
  if (objects.path) {
    flight.places = {(objects.path->least + objects.path->most) / 2};
    flight.reach += (objects.path->most - objects.path->least) / 2;
    return flight;
  }
  if (!objects.moves && !objects.is_kinematic) return flight;
  const auto velocity = ConstantOf(objects.settings->Get("linear_velocity"));
  if (!velocity) return std::nullopt;
  flight.velocity = *velocity;
  if (!objects.moves) return flight;
  if (!scene.pull) return std::nullopt;
  flight.acceleration = *scene.pull;
  return flight;
}

/// The range of p + v t + a t^2 / 2 for 0 <= t <= time.
Bounds RangeOf(double p, double v, double a, double time) {
  Bounds range{p, p};
  const auto add = [&](double t) {
    const double at = p + v * t + a * t * t / 2;
    range = {std::min(range.least, at), std::max(range.most, at)};
  };
  add(time);
  if (a != 0 && -v / a > 0 && -v / a < time) add(-v / a);
  return range;
}

/// True if a box with half sides `reach` about the origin may meet a point on this path. Exact on
/// straight paths.
bool Meets(const Vector3d& p, const Vector3d& v, const Vector3d& a, const Vector3d& reach,
           double time) {
  double from = 0, to = time;
  for (int axis = 0; axis < 3; ++axis) {
    const Bounds range = RangeOf(p[axis], v[axis], a[axis], time);
    if (range.least > reach[axis] || range.most < -reach[axis]) return false;
    if (a[axis] != 0 || v[axis] == 0) continue;
    const double one = (-reach[axis] - p[axis]) / v[axis], two = (reach[axis] - p[axis]) / v[axis];
    from = std::max(from, std::min(one, two));
    to = std::min(to, std::max(one, two));
  }
  return from <= to;
}

bool MayMeet(const SceneFacts& scene, const GroupFacts& a, const GroupFacts& b) {
  const auto one = FlightOf(scene, a), two = FlightOf(scene, b);
  // Whatever their acceleration is, it is the same for both.
  const auto velocity = ConstantOf(a.settings->Get("linear_velocity"));
  const auto other = ConstantOf(b.settings->Get("linear_velocity"));
  const bool fly_alike = a.moves && b.moves && velocity && other && *velocity == *other &&
                         !a.linked && !b.linked && !(a.spin > 0) && !(b.spin > 0) &&
                         !(a.overlap > 0);
  if (fly_alike) return false;
  if (!one || !two || one->places.empty() || two->places.empty() ||
      one->places.size() * two->places.size() > kMostPairs)
    return true;
  // Objects of one group keep their distance unless they turn.
  return std::ranges::any_of(one->places, [&](const Vector3d& p) {
    return std::ranges::any_of(two->places, [&](const Vector3d& q) {
      return (&a != &b || p != q) &&
             Meets(q - p, two->velocity - one->velocity, two->acceleration - one->acceleration,
                   one->reach + two->reach, scene.Time());
    });
  });
}

}  // namespace

// The first contact of a run is between objects that fly freely until then.
void FindContacts(SceneFacts& scene) {
  bool may_meet = false;
  for (GroupFacts& a : scene.groups) {
    if (scene.has_walls && a.moves && scene.collisions->MayTouchWalls(a.index))
      a.may_touch = may_meet = true;
    for (GroupFacts& b : scene.groups) {
      if (b.index < a.index || (a.index == b.index && a.quantity < 2) || !(a.moves || b.moves) ||
          !scene.collisions->MayTouch(a.index, b.index))
        continue;
      a.may_touch = b.may_touch = true;
      may_meet = may_meet || MayMeet(scene, a, b);
    }
  }
  if (may_meet) return;
  for (GroupFacts& objects : scene.groups) objects.may_touch = false;
}

namespace {

/// The largest gap, in sides, between objects that are one stack.
constexpr double kStackGap = 0.25;
/// Stacks are sought among this many places.
constexpr std::size_t kMostPlaces = 300;
/// Of the least side: a smaller gap is none.
constexpr double kAdjoins = 1e-3;

struct Placed {
  GroupFacts* objects;
  Vector3d at;
  double height = 1;  ///< number of objects from the ground to this one
};

bool StandsOn(const Placed& above, const Placed& below) {
  const Vector3d apart = above.at - below.at;
  const Vector3d reach = (above.objects->most_sides + below.objects->most_sides) / 2;
  const double gap = apart.y() - reach.y();
  const double least = std::min(above.objects->least_side, below.objects->least_side);
  return std::abs(apart.x()) < reach.x() && std::abs(apart.z()) < reach.z() &&
         std::abs(gap) < kStackGap * least;
}

/// True if a face of one continues one of the other, which is beside it.
bool Adjoin(const Placed& one, const Placed& other) {
  const Vector3d reach = (one.objects->most_sides + other.objects->most_sides) / 2;
  const Vector3d gap = (one.at - other.at).cwiseAbs() - reach;
  const double near = kAdjoins * std::min(one.objects->least_side, other.objects->least_side);
  return (gap.array() < near).all() && (gap.array().abs() < near).count() == 1;
}

}  // namespace

void FindAdjoining(SceneFacts& scene) {
  std::vector<Placed> placed;
  for (GroupFacts& objects : scene.groups)
    if (!objects.moves && !objects.is_kinematic && objects.settings->WordOr("type") == "cuboid" &&
        schema::IsZero(objects.settings->Get("orientation")))
      for (const Vector3d& at : objects.places) placed.push_back({&objects, at});
  // Of more places, only those that are listed one after the other are compared.
  const std::size_t most = placed.size() > kMostPlaces ? 1 : placed.size();
  for (std::size_t i = 0; i < placed.size(); ++i)
    for (std::size_t j = i + 1; j < std::min(placed.size(), i + 1 + most); ++j)
      if (Adjoin(placed[i], placed[j]))
        placed[i].objects->adjoins = placed[j].objects->adjoins = true;
}

void FindTowers(SceneFacts& scene) {
  std::vector<Placed> placed;
  for (GroupFacts& objects : scene.groups)
    if (objects.moves)
      for (const Vector3d& at : objects.places) placed.push_back({&objects, at});
  if (placed.size() > kMostPlaces) return;
  std::ranges::sort(placed, {}, [](const Placed& object) { return object.at.y(); });
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      if (scene.collisions->MayTouch(placed[i].objects->index, placed[j].objects->index) &&
          StandsOn(placed[i], placed[j]))
        placed[i].height = std::max(placed[i].height, placed[j].height + 1);
    GroupFacts& objects = *placed[i].objects;
    objects.stacked = std::max(objects.stacked, placed[i].height);
    objects.tower = std::max(objects.tower, placed[i].height);
  }
}

}  // namespace cdb::lints
