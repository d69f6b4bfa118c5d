// Lints about contacts: too deep, too soft, or missed between two steps.
#include <algorithm>
#include <cmath>

#include "compiler/analysis/coverage.h"
#include "compiler/analysis/reference.h"
#include "compiler/lints/lint_facts.h"
#include "compiler/schema/catalogue.h"

namespace cdb::lints {
namespace {

using Eigen::Vector3d;

// Measured.
constexpr double kLongStepOnPlane = 0.04, kLongStepOnBox = 0.3, kLongStepOfBall = 5;
constexpr double kThinWall = 1.5, kFastHit = 2, kSoftContact = 0.04, kThinShape = 30;
constexpr double kManyEdges = 1, kForeseen = 1, kLossy = 1;
/// On a plane, a box that slides has one contact at a time, at which it sinks in.
constexpr double kLongStepOfSlider = 0.0125;
/// m/s; Bullet gives no restitution to slower contacts
/// (btContactSolverInfo::m_restitutionVelocityThreshold).
constexpr double kSlowContact = 0.2;
/// Bullet's contact threshold over the side, and the fractions of the energy of an approach whose
/// loss, and whose excess in a rebound, are drifting.
constexpr double kContactGap = 0.015, kLostEnergy = 0.1, kExcessEnergy = 0.05;
/// m; Bullet pushes deeper overlaps apart without adding to the velocity
/// (btContactSolverInfo::m_splitImpulsePenetrationThreshold).
constexpr double kPushDepth = 0.04;
/// Without restitution a push may give this fraction of the energy by which the verdict scales
/// drift, with this height of a fall in sides in it.
constexpr double kRise = 0.01, kFallOfScale = 25;
/// Cylinders of 0.1 to 5 m that roll slower than half of sqrt(g size) gain a tenth after a time of
/// 4.8 sqrt(size / g) or more, capsules after 15; none that is faster than sqrt(g size) does.
constexpr double kRolls = 4.8;
/// Of cubes of 0.1 to 2 m at 0.5 to 8 m/s, with mu from 0.05 to 0.6, at 60 to 480 Hz, none was
/// twisted or braked wrongly within 4.5 sqrt(size / g), 39 % within 9 to 10, 51 % within 10 to 18.
constexpr double kSlides = 12;

/// Its narrow phase does, so that bodies rest on planes on all their points, and round ones on
/// whole lines.
bool HasAllPoints(const SceneFacts& scene) {
  return schema::ListsAllPoints(scene.world->WordOr("narrow_phase"));
}

bool IsAlongOneAxis(const Vector3d& v) { return (v.array() != 0).count() <= 1; }

/// As a fraction of its size: a ball that starts no higher above the floor touches it at once.
constexpr double kOnFloor = 0.01;

/// One ball, or several side by side, that start on their support, at rest or rolling.
bool LiesAsBall(const SceneFacts& scene, const GroupFacts& objects) {
  if (!IsBall(objects) || objects.stacked > 1 || objects.velocity.y() > 0) return false;
  const double above = scene.rests ? objects.gap : scene.FallHeight(objects);
  return above <= kOnFloor * objects.least_side;
}

/// The time until two numbers that separate at `speed` with acceleration `pull` are `way` apart;
/// negative if never.
double TimeUntil(double way, double speed, double pull) {
  if (pull == 0) return speed * way > 0 ? way / speed : -1;
  const double square = speed * speed + 2 * pull * way;
  if (square < 0) return -1;
  // The earliest root after the start.
  const double root = std::sqrt(square);
  const double one = (-speed - root) / pull, two = (-speed + root) / pull;
  const double earlier = std::min(one, two), later = std::max(one, two);
  return earlier > 0 ? earlier : later;
}

/// The impact of an object on a fixed one, along one axis.
struct Impact {
  double speed = 0, thickness = 0;
  bool is_certain = false;  ///< it starts at a known position, and its path leads there
};

/// An object that flies from a known position to the fixed one along `axis`.
std::optional<Impact> FlightTo(const SceneFacts& scene, const GroupFacts& objects,
                               const GroupFacts& fixed, int axis) {
  const auto from = FixedPositionOf(objects), to = FixedPositionOf(fixed);
  const auto velocity = ConstantOf(objects.settings->Get("linear_velocity"));
  const auto turn = ConstantOf(fixed.settings->Get("orientation"));
  if (!from || !to || !velocity || !scene.pull || !turn || !turn->isZero(0)) return std::nullopt;
  const double radius = objects.least_side / 2;
  const Vector3d half = fixed.most_sides / 2, apart = *to - *from;
  const double way = std::abs(apart[axis]) - half[axis] - radius;
  const double time =
      TimeUntil(std::copysign(way, apart[axis]), (*velocity)[axis], (*scene.pull)[axis]);
  if (!(way >= 0) || !(time > 0) || time > scene.Time()) return Impact{};
  const Vector3d missed = apart - time * *velocity - time * time / 2 * *scene.pull;
  for (const int other : {(axis + 1) % 3, (axis + 2) % 3})
    if (std::abs(missed[other]) > half[other]) return Impact{};
  const double speed = std::abs((*velocity)[axis] + (*scene.pull)[axis] * time);
  return Impact{speed, fixed.least_sides[axis], true};
}

/// Along an axis, of any point of a kinematic object.
double KinematicSpeed(const GroupFacts& objects, int axis) {
  const double of_path = objects.path ? objects.path->fastest : 0;
  return objects.velocity[axis] + objects.spin * objects.most_sides.norm() / 2 + of_path;
}

/// The value of the lint for the fixed and the kinematic objects of a scene.
Estimate ThinObject(const SceneFacts& scene, const GroupFacts& objects) {
  Estimate worst{0, kThinWall};
  // Falls begin within the cube.
  const double fallen = std::min(scene.FallSpeed(objects), std::sqrt(2 * scene.g * scene.side));
  const Vector3d gained =
      scene.g > 0 ? Vector3d(fallen / scene.g * scene.acceleration) : Vector3d(Vector3d::Zero());
  for (const GroupFacts& fixed : scene.groups) {
    if (fixed.moves || !scene.collisions->MayTouch(objects.index, fixed.index)) continue;
    const auto turn = ConstantOf(fixed.settings->Get("orientation"));
    const bool is_turned = !turn || !turn->isZero(0);
    // A surface is thin everywhere.
    const double least = fixed.is_surface ? 0 : fixed.least_side;
    for (int axis = 0; axis < 3; ++axis) {
      const double approach = fixed.is_kinematic ? KinematicSpeed(fixed, axis) : 0;
      const Impact unknown{std::hypot(objects.velocity[axis], gained[axis]) + approach,
                           is_turned || fixed.is_surface ? least : fixed.least_sides[axis], false};
      const Impact impact = fixed.is_kinematic || fixed.is_surface
                                ? unknown
                                : FlightTo(scene, objects, fixed, axis).value_or(unknown);
      const double value = impact.speed * scene.timestep / (objects.least_side + impact.thickness);
      if (value <= worst.value) continue;
      worst = {value, kThinWall, ShorterStep(scene, value, kThinWall), !impact.is_certain};
    }
  }
  return worst;
}

double FrictionOnWalls(const SceneFacts& scene, const GroupFacts& objects) {
  return BoundsOf(*objects.settings, "friction").least * scene.world->Real("world.wall_friction");
}

/// m/s^2: the part of the weight along the floor. 0 if it is drawn or changes.
double PullAlongFloor(const SceneFacts& scene) {
  return scene.pull ? std::hypot(scene.pull->x(), scene.pull->z()) : 0;
}

double SpeedAlongFloor(const GroupFacts& objects) {
  return std::hypot(objects.velocity.x(), objects.velocity.z());
}

/// True if a box on the floor slides from the start, or all the time, as its weight has a component
/// along the floor that friction does not hold.
bool Slides(const SceneFacts& scene, const GroupFacts& objects) {
  if (IsBall(objects) || scene.rests) return false;
  const bool is_steep = scene.pull && PullAlongFloor(scene) > FrictionOnWalls(scene, objects) *
                                                                  std::abs(scene.pull->y());
  return is_steep || SpeedAlongFloor(objects) > 0;
}

}  // namespace

std::optional<Estimate> LongStep(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight(objects)) return std::nullopt;
  const double value = scene.g * scene.timestep * scene.timestep / objects.least_side;
  const bool on_plane = scene.has_walls && !scene.has_box_walls;
  const bool lies = LiesAsBall(scene, objects);
  // On a plane such a ball keeps its position with any time step.
  if (lies && on_plane) return std::nullopt;
  const bool slides = on_plane && value < kLongStepOnPlane && Slides(scene, objects);
  const double threshold = lies       ? kLongStepOfBall
                           : slides   ? kLongStepOfSlider
                           : on_plane ? kLongStepOnPlane
                                      : kLongStepOnBox;
  // A slider may stop, and a ball that falls is pushed out of some depths without flying up.
  const bool open = slides || (IsBall(objects) && !lies);
  return Estimate{value, threshold, ShorterStepSquared(scene, value, threshold), open};
}

std::optional<Estimate> SlidingBox(const SceneFacts& scene, const GroupFacts& objects) {
  const bool on_plane = scene.has_walls && !scene.has_box_walls && scene.HasWeight(objects) &&
                        scene.collisions->MayTouchWalls(objects.index);
  if (!on_plane || !scene.pull || HasAllPoints(scene)) return std::nullopt;
  if (!MayBe(objects.settings->Get("type"), "cuboid") || !Slides(scene, objects))
    return std::nullopt;
  // It starts flat on the floor.
  const auto turn = ConstantOf(objects.settings->Get("orientation"));
  const double height = (objects.most_sides.y() - scene.side) / 2 + kOnFloor * objects.least_side;
  if (!turn || !turn->isZero(0) || objects.velocity.y() > 0 || objects.places.empty() ||
      !std::ranges::all_of(objects.places, [&](const Vector3d& at) { return at.y() <= height; }))
    return std::nullopt;
  const double friction = FrictionOnWalls(scene, objects);
  if (!(friction > 0)) return std::nullopt;
  const double braked = friction * std::abs(scene.pull->y()) - PullAlongFloor(scene);
  const double stops = braked > 0 ? SpeedAlongFloor(objects) / braked : scene.Time();
  const double value = std::min(stops, scene.Time()) * std::sqrt(scene.g / objects.least_side);
  const bool open = true;  // most such boxes are twisted, not all
  return Estimate{value, kSlides, 0, open};
}

std::optional<Estimate> ThinWall(const SceneFacts& scene, const GroupFacts& objects) {
  if (!objects.may_touch || MayBeOn(objects, "ccd")) return std::nullopt;
  const Estimate object = ThinObject(scene, objects);
  if (!scene.has_box_walls || !scene.collisions->MayTouchWalls(objects.index)) return object;
  // Walls are perpendicular to the axes.
  const double value = scene.FastestComponent(objects) * scene.timestep /
                       (objects.least_side + analysis::kWallThickness * scene.side);
  const Estimate wall{value, kThinWall, ShorterStep(scene, value, kThinWall)};
  return object.value > value ? object : wall;
}

std::optional<Estimate> FastHit(const SceneFacts& scene, const GroupFacts& objects) {
  if (!objects.may_touch || MayBeOn(objects, "ccd")) return std::nullopt;
  // A ball that falls on a fixed object or hits it head-on does not spin.
  const bool is_ball = IsBall(objects);
  if (is_ball && scene.moving == 1 && IsAlongOneAxis(objects.velocity)) return std::nullopt;
  const double speed = is_ball ? objects.velocity.maxCoeff() : scene.FastestComponent(objects);
  const double value = speed * scene.timestep / objects.least_side;
  // Objects that do not cross the room may hit nothing; without walls, how far they fall before
  // they hit is not known.
  const double own = objects.velocity.maxCoeff();
  const bool open = speed * scene.Time() < scene.side || (!scene.has_walls && speed > own);
  return Estimate{value, kFastHit, ShorterStep(scene, value, kFastHit), open};
}

std::optional<Estimate> SoftContact(const SceneFacts& scene, const GroupFacts& objects) {
  if (!scene.HasWeight(objects)) return std::nullopt;
  const double softest = BoundsOf(*objects.settings, "contact_stiffness").least;
  if (!(softest > 0)) return std::nullopt;
  const double sinks = objects.stacked * objects.mass.most * scene.g / softest;
  // With a damper stronger than the spring, half of the scenes come to rest.
  const double damper = BoundsOf(*objects.settings, "contact_damping").least;
  const bool open = damper * damper > 4 * softest * objects.mass.most;
  return Estimate{sinks, kSoftContact, softest * Excess(sinks, kSoftContact), open};
}

std::optional<Estimate> ThinShape(const SceneFacts& scene, const GroupFacts& objects) {
  if (!objects.may_touch) return std::nullopt;
  const schema::Value& type = objects.settings->Get("type");
  const bool is_round = MayBe(type, "sphere") && objects.elongation == 1;
  if (is_round) return std::nullopt;
  // Contacts with planes are found without GJK.
  if (scene.count < 2 && !scene.has_box_walls) return std::nullopt;
  // The depth of contacts becomes wrong, but only some runs fail because of it.
  const bool open = true;
  return Estimate{objects.elongation, kThinShape, Harmless(kThinShape), open};
}

std::optional<Estimate> InternalEdges(const SceneFacts& scene, const GroupFacts& objects) {
  const bool meets_edges = std::ranges::any_of(scene.groups, [&](const GroupFacts& ground) {
    const bool has_edges =
        ground.adjoins || (ground.is_surface && ground.settings->WordOr("edges") == "bullet");
    return has_edges && scene.collisions->MayTouch(objects.index, ground.index);
  });
  if (!meets_edges || scene.rests) return std::nullopt;
  const double way = objects.speed * scene.Time() + scene.g * std::pow(scene.Time(), 2) / 2;
  // Where the object meets the edges is not known here.
  const bool open = true;
  return Estimate{way / objects.least_side, kManyEdges, 0, open};
}

std::optional<Estimate> ForeseenBounce(const SceneFacts& scene, const GroupFacts& objects) {
  if (!objects.may_touch || !MayBeOn(objects, "ccd") ||
      !(BoundsOf(*objects.settings, "restitution").most > 0))
    return std::nullopt;
  // Bullet foresees the contacts of objects that move by more than their inner radius in a step.
  const double value = scene.FastestSpeed(objects) * scene.timestep / (objects.least_side / 2);
  if (value < kForeseen) return std::nullopt;
  const bool open = true;  // it depends on where in the step they meet
  return Estimate{value, kForeseen, ShorterStep(scene, value, kForeseen), open};
}

namespace {

/// 0 for a bound that is harmless itself, so that below the limit nothing can happen.
double IfHarmful(double bound) { return bound < kLossy ? 0 : bound; }

}  // namespace

std::optional<Estimate> LossyBounce(const SceneFacts& scene, const GroupFacts& objects) {
  const bool is_faithful = scene.world->WordOr("contact") == "faithful";
  const double restitution = BoundsOf(*objects.settings, "restitution").most;
  if (!objects.may_touch || scene.rests || !scene.are_gains_judged ||
      (is_faithful && restitution < 1))
    return std::nullopt;
  const double speed = scene.FastestSpeed(objects);
  if (!(speed > 0)) return std::nullopt;
  // What pushes an overlap apart adds to the speed of the rebound.
  const double depth = std::min(kPushDepth, speed * scene.timestep);
  const double push = scene.world->Real("solver.erp") * depth / scene.timestep;
  if (!(restitution > 0)) {
    if (scene.moving > 1) return std::nullopt;  // the push is small beside the energy of all
    const double scale = std::pow(speed, 2) / 2 + kFallOfScale * scene.g * objects.least_side;
    return Estimate{IfHarmful(std::pow(push, 2) / 2 / scale / kRise), kLossy,
                    kSlowContact / Harmless(kLossy), true};
  }
  const double pushed = restitution + push / speed;
  const double gain =
      is_faithful ? 0 : IfHarmful((std::pow(pushed, 2) - std::pow(restitution, 2)) / kExcessEnergy);
  // It depends on where in a step they meet, or on the angle.
  const bool open = true;
  if (!scene.only_contacts_take_energy)
    return Estimate{gain, kLossy, kSlowContact / Harmless(kLossy), open};
  // Bullet stops an object at a contact that is up to kContactGap sides away before it gives it the
  // speed of the rebound, which this gap shortens. Elastic objects also gain energy.
  const double eaten = kContactGap * objects.longest_side / scene.timestep / speed;
  const double left = std::max(0.0, restitution - eaten);
  const double change = (std::pow(restitution, 2) - std::pow(left, 2)) / kLostEnergy;
  const double value = is_faithful        ? kSlowContact / speed
                       : restitution == 1 ? std::max({change, gain, kLossy})
                                          : std::max(change, gain);
  return Estimate{value, kLossy, kSlowContact / Harmless(kLossy), open};
}

std::optional<Estimate> RollingGain(const SceneFacts& scene, const GroupFacts& objects) {
  const auto may_roll = [](const GroupFacts& group) {
    return analysis::MayRoll(group.settings->Get("type"));
  };
  // Beside others, what it gains is small.
  const bool all_roll = std::ranges::all_of(
      scene.groups, [&](const GroupFacts& group) { return !group.moves || may_roll(group); });
  if (HasAllPoints(scene) || !all_roll || scene.rests || !scene.are_gains_judged ||
      !scene.HasWeight(objects))
    return std::nullopt;
  const bool has_slope = std::ranges::any_of(scene.groups, [](const GroupFacts& group) {
    const auto turn = ConstantOf(group.settings->Get("orientation"));
    return !group.moves && (!turn || turn->x() != 0 || turn->z() != 0);
  });
  const bool is_tilted = PullAlongFloor(scene) > 0 || has_slope;
  const double speed = SpeedAlongFloor(objects);
  if (!is_tilted && !(speed > 0)) return std::nullopt;
  if (speed > std::sqrt(scene.g * objects.longest_side)) return std::nullopt;
  const bool open = true;  // it may slide, or stop
  return Estimate{scene.Time() * std::sqrt(scene.g / objects.least_side), kRolls, 0, open};
}

}  // namespace cdb::lints
