#include "library/closed_forms/fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compiler/analysis/expectation.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::closed_forms {
namespace {

using Eigen::Vector3d;

bool IsScheduled(const schema::Value& value) {
  const schema::Call* call = schema::AsCall(value);
  return call != nullptr && (call->name == "every" || call->name == "rotating");
}

bool IsOfLinks(std::string_view form) { return form == "spring" || form == "pendulum"; }

}  // namespace

Fit::Fit(std::string_view form, const plan::Scene& scene, const layouts::InitialState& state)
    : form_(form),
      scene_(scene),
      state_(state),
      end_(scene.world.Real("timestep") *
           static_cast<double>(scene.world.Count("warmup") + scene.world.Count("cycles"))),
      half_(scene.world.Real("world.side") / 2) {
  if (state.objects.empty()) Refuse("there is no object", "make the quantity 1 or more");
  if (IsScheduled(scene.world.Get("acceleration")))
    Refuse("the acceleration is on a schedule", "give it one value");
  for (const plan::Group& group : scene.groups)
    for (const auto velocity :
         {schema::GroupParameter("linear_velocity"), schema::GroupParameter("angular_velocity")})
      if (IsScheduled(group.settings.Get(velocity)))
        Refuse(fmt::format("{}.{} is on a schedule", group.name, velocity.name()),
               "give it one value");
  if (!analysis::Collisions(scene).AllMayTouch())
    Refuse("collides_with keeps objects from touching", "take it out");
  for (const plan::Group& group : scene.groups)
    if (group.HasLinks() && !IsOfLinks(form))
      Refuse(fmt::format("the {} are linked", group.name), "make links.type none");
  if (!scene.joints.empty()) Refuse("it has joints", "remove them");
  for (const plan::Group& group : scene.groups)
    for (const schema::Parameter& parameter : schema::Schema())
      if (parameter.closed_forms_need_default && group.settings.Count("quantity") > 0 &&
          group.settings.Has(parameter))
        Refuse(fmt::format("{}.{} is {}", group.name, parameter.name,
                           schema::LabelOf(group.settings.ValueOf(parameter))),
               fmt::format("make it {}", parameter.first_default));
  for (std::size_t i = 0; i < size(); ++i)
    if (object(i).IsFixed())
      Refuse(Name(i) + (object(i).is_kinematic ? " is kinematic" : " is fixed"), "give it a mass");
}

void Fit::Refuse(const std::string& what, const std::string& remedy) const {
  throw library::SceneError(
      fmt::format("closed form `{}` does not apply to this scene: {}", form_, what), remedy);
}

bool Fit::HasWall(int axis, int sign) const {
  const std::string_view walls = scene_.world.WordOr("world.walls");
  return walls == "all" || (walls == "floor" && axis == 1 && sign < 0);
}

std::string Fit::Name(std::size_t index) const {
  return fmt::format("object {} of {} (group `{}`)", index + 1, size(),
                     scene_.groups[object(index).group].name);
}

void Fit::RequireOneObject() const {
  if (size() != 1) Refuse(fmt::format("there are {} objects", size()), "the closed form has one");
}

void Fit::RequireBall(std::size_t index) const {
  if (!object(index).solid.IsBall())
    Refuse(Name(index) + " is not a ball", "make its type sphere and its aspect 1 : 1 : 1");
}

void Fit::RequireNoSpin(std::size_t index) const {
  if (!object(index).angular_velocity.isZero(0))
    Refuse(Name(index) + " spins", "make its angular_velocity 0");
}

void Fit::RequireNoVelocity(std::size_t index) const {
  if (!object(index).linear_velocity.isZero(0))
    Refuse(Name(index) + " moves at the start", "make its linear_velocity 0");
}

void Fit::RequireNoAcceleration() const {
  if (!acceleration().isZero(0)) Refuse("there is an acceleration", "make it 0");
}

void Fit::RequireFloor() const {
  if (!HasWall(1, -1)) Refuse("there is no floor", "make world.walls floor");
  if (!(Pressing() > 0))
    Refuse("the acceleration does not press onto the floor", "make its y negative");
}

void Fit::RequireLevelFloor() const {
  RequireFloor();
  if (!Downhill().isZero(0)) Refuse("the acceleration is not straight down", "make its x and z 0");
}

void Fit::RequireLevelVelocity(std::size_t index) const {
  const Vector3d& velocity = object(index).linear_velocity;
  if (velocity.y() != 0)
    Refuse(Name(index) + " does not move along the floor", "make the y of its linear_velocity 0");
  if (velocity.isZero(0)) Refuse(Name(index) + " does not move", "give it a linear_velocity");
}

void Fit::RequireLink(std::string_view types) const {
  const std::string_view type = links().WordOr("links.type");
  const bool fits = type != "none" && types.find(type) != std::string_view::npos;
  if (!fits)
    Refuse(fmt::format("links.type of the {} is {}", scene_.groups[object(0).group].name, type),
           fmt::format("make it {}", types));
  if (!links().On("links.anchor")) Refuse("the object hangs from nothing", "make links.anchor on");
}

int Fit::RequireLevelCuboid(std::size_t index) const {
  if (object(index).solid.shape != objects::Shape::kCuboid)
    Refuse(Name(index) + " is not a cuboid", "make its type cuboid");
  const Vector3d up = object(index).pose.orientation.conjugate() * Vector3d::UnitY();
  int upright = 0;
  if (up.cwiseAbs().maxCoeff(&upright) < 1 - kSame)
    Refuse(Name(index) + " is not level", "make its orientation 0, or turn it about y alone");
  return upright;
}

void Fit::RequireStanding(std::size_t index, double gap, double height) const {
  if (std::abs(gap) <= kStandingGap * height) return;
  Refuse(fmt::format("{} is {:.4g} m {} what it should stand on", Name(index), std::abs(gap),
                     gap > 0 ? "above" : "inside"),
         fmt::format("a gap of at most {:.4g} m counts as contact", kStandingGap * height));
}

bool Fit::IsOverBase(std::size_t index, int upright, const Vector3d& off) const {
  Vector3d inside = object(index).pose.orientation.conjugate() * off;
  inside[upright] = 0;
  return (inside.cwiseAbs().array() <= object(index).solid.HalfExtents().array()).all();
}

void Fit::RequireClearOfWalls(std::size_t index, const objects::Box& box, const Vector3d& from,
                              const Vector3d& velocity, const Vector3d& acceleration,
                              double seconds) const {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {-1, 1}) {
      if (!HasWall(axis, sign)) continue;
      const double surface = sign < 0 ? box.lower[axis] : box.upper[axis];
      const double v = velocity[axis], a = acceleration[axis];
      const auto out = [&](double t) {
        return sign * (from[axis] + surface + v * t + a * t * t / 2 - WallAt(sign));
      };
      const double turn = -v / a;  // the turning point, if any
      const bool turns = turn > 0 && turn < seconds;
      if (std::max({out(0), out(seconds), turns ? out(turn) : out(0)}) < 0) continue;
      Refuse(fmt::format("{} reaches the wall {}{} before the end", Name(index),
                         sign < 0 ? '-' : '+', "xyz"[axis]),
             "make the run shorter, world.side larger, or world.walls none");
    }
  }
}

objects::Box ReachOf(const layouts::ObjectState& object) {
  if (object.angular_velocity.isZero(0))
    return objects::Bounds(object.solid, object.pose.orientation);
  const Vector3d reach = Vector3d::Constant(object.solid.OuterRadius());
  return {-reach, reach};
}

Momenta MomentaOf(const std::vector<layouts::ObjectState>& objects,
                  const std::vector<Vector3d>& positions, const std::vector<Vector3d>& velocities,
                  const std::vector<Vector3d>& spins) {
  double mass = 0;
  Vector3d centre = Vector3d::Zero();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    mass += objects[i].mass;
    centre += objects[i].mass * positions[i];
  }
  centre /= mass;
  Momenta sum;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Vector3d momentum = objects[i].mass * velocities[i];
    sum.linear += momentum;
    sum.angular += (positions[i] - centre).cross(momentum);
    if (spins.empty()) continue;
    const Eigen::Matrix3d turn = objects[i].pose.orientation.toRotationMatrix();
    const Vector3d inertia = objects[i].mass * objects[i].solid.InertiaPerMass();
    sum.angular += turn * inertia.cwiseProduct(turn.transpose() * spins[i]);
  }
  return sum;
}

}  // namespace cdb::closed_forms
