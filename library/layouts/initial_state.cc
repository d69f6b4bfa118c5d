#include "library/layouts/initial_state.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <string_view>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/reference.h"
#include "compiler/analysis/soft.h"
#include "library/distributions/draw.h"
#include "library/distributions/object_numbers.h"
#include "library/distributions/stream.h"
#include "library/layouts/placement.h"
#include "library/layouts/pose_table.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

Eigen::Quaterniond DrawOrientation(distributions::Draw& orientation) {
  std::string_view word;
  const auto turn = orientation.VectorOrWord(&word);
  return turn ? TurnAbout(*turn) : orientation.stream().Turn();
}

/// The orientation of the body's axes after a rotation of the object by `turn`.
Eigen::Quaterniond BodyTurn(const objects::Solid& solid, const Eigen::Quaterniond& turn) {
  return objects::BodyOf(solid, {Vector3d::Zero(), turn}).orientation;
}

/// Also sets positions, which the layout only checks.
void TakeTable(const plan::Group& group, std::span<ObjectState> objects) {
  const schema::Call* poses = analysis::PosesOf(group);
  if (poses == nullptr || objects.empty()) return;
  const PoseTable table = ReadPoseTable(*poses);
  if (table.rows.size() != objects.size())
    throw library::SceneError(
        fmt::format("group `{}` has {} objects, but its file has the poses of {}", group.name,
                    objects.size(), table.rows.size()),
        "remove the quantity, or name another file", group.name);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const PoseRow& row = table.rows[i];
    ObjectState& object = objects[i];
    const Eigen::Quaterniond turn = table.has_orientation
                                        ? row.orientation
                                        : objects::OriginOf(object.solid, object.pose).orientation;
    object.pose = objects::BodyOf(object.solid, {row.position, turn});
    if (table.has_linear_velocity) object.linear_velocity = row.linear_velocity;
    if (table.has_angular_velocity) object.angular_velocity = row.angular_velocity;
  }
}

/// Also sets the pose, to that at the start.
void TakePath(const plan::Group& group, std::span<ObjectState> objects) {
  const schema::Call* call = analysis::PathOf(group);
  if (call == nullptr || objects.empty()) return;
  const auto path = std::make_shared<const Path>(ReadPath(*call));
  for (ObjectState& object : objects) {
    if (!object.is_kinematic)
      throw library::SceneError(
          fmt::format("the objects of group `{}` have a path but are not kinematic", group.name),
          "write mass kinematic", group.name);
    object.path = path;
    object.pose = PoseAt(object, 0);
  }
}

/// If it cannot be made, the error names the type of the group.
objects::Solid MakeSolid(objects::SolidFactory& solids, const schema::Value& type,
                         const Vector3d& sides, const Vector3d& aspect,
                         const Eigen::Vector2d& exponents, const std::string& group) {
  try {
    return solids.Make(type, sides, aspect, exponents);
  } catch (const library::SceneError& error) {
    if (!error.group().empty()) throw;
    throw library::SceneError(error.cause(), error.remedy(), group, "type");
  }
}

/// The box of the nodes of a soft body with its margin around them. m.
void AddThickness(const schema::Value& type, double margin, objects::Solid& solid) {
  const std::string_view kind = schema::AsCall(type)->name;
  const Vector3d nodes(solid.sides.x(), analysis::IsSoftSolid(type) ? solid.sides.y() : 0,
                       kind == analysis::kRopeCall ? 0 : solid.sides.z());
  solid.sides = nodes + Vector3d::Constant(2 * margin);
}

void CheckMargin(const ObjectState& object, const std::string& group) {
  const double margin = object.numbers["margin"], least = object.solid.LeastHalfExtent();
  if (margin < least || margin == kBulletMargin || !object.solid.HasMargin()) return;
  throw library::SceneError(
      fmt::format("margin {:.6g} m is too large for an object whose least half extent is {:.6g} m",
                  margin, least),
      "make it smaller", group, "margin");
}

void DrawGroup(const plan::Scene& scene, std::size_t index, objects::SolidFactory& solids,
               std::vector<ObjectState>& objects) {
  const plan::Group& group = scene.groups[index];
  const auto draw = [&](schema::ParameterRef<true, schema::ValueKind::kDrawn> parameter) {
    return distributions::Draw(scene, group, parameter);
  };
  const Vector3d aspect = std::get<schema::Ratio>(group.settings.Get("aspect")).parts;
  distributions::Draw type = draw("type"), orientation = draw("orientation");
  distributions::Draw linear_velocity = draw("linear_velocity"),
                      angular_velocity = draw("angular_velocity"), force = draw("force"),
                      torque = draw("torque");
  distributions::ObjectNumbers numbers(scene, group);
  const std::uint64_t quantity = group.settings.Count("quantity");
  for (std::uint64_t i = 0; i < quantity; ++i) {
    ObjectState& object = objects.emplace_back();
    numbers.Next();
    object.group = index;
    const schema::Value& chosen = type.Choice();
    const Eigen::Vector2d exponents(*numbers.Find(*schema::GroupParameter("e1")),
                                    *numbers.Find(*schema::GroupParameter("e2")));
    object.solid = MakeSolid(solids, chosen, numbers.Sides(), aspect, exponents, group.name);
    if (analysis::IsSoft(chosen))
      AddThickness(chosen, numbers.Find(*schema::GroupParameter("margin")).value_or(kBulletMargin),
                   object.solid);
    numbers.SetVolume(object.solid.Volume());
    const schema::Parameter& mass = *schema::GroupParameter("mass");
    object.mass = numbers.Find(mass).value_or(mass.number_of_word);
    object.is_kinematic = numbers.Word(mass) == analysis::kKinematicWord;
    object.pose.orientation = BodyTurn(object.solid, DrawOrientation(orientation));
    object.linear_velocity = linear_velocity.Vector();
    object.angular_velocity = angular_velocity.Vector();
    object.force = force.Vector();
    object.torque = torque.Vector();
    object.numbers.ForEach([&](const schema::Parameter& parameter, double& number) {
      number = numbers.Find(parameter).value_or(parameter.number_of_word);
    });
    if (!analysis::IsSoft(chosen)) CheckMargin(object, group.name);
  }
  TakeTable(group, std::span(objects).last(quantity));
  TakePath(group, std::span(objects).last(quantity));
  if (!group.HasLinks()) return;
  // The other value is the word `same`.
  const schema::Number* end_mass = schema::AsNumber(group.settings.Get("links.end_mass"));
  if (end_mass != nullptr) objects.back().mass = end_mass->AsReal();
}

}  // namespace

Eigen::Quaterniond TurnAbout(const Vector3d& rotation_vector) {
  const double angle = rotation_vector.stableNorm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  const Vector3d axis = rotation_vector / angle;
  const double sine = std::sin(angle / 2);
  return {std::cos(angle / 2), axis.x() * sine, axis.y() * sine, axis.z() * sine};
}

objects::Pose PoseAt(const ObjectState& object, double time) {
  objects::Pose pose = object.pose;
  pose.position += time * object.linear_velocity;
  if (object.path != nullptr && object.path->has_orientation()) {
    pose.orientation = BodyTurn(object.solid, object.path->OrientationAt(time));
  } else if (!object.angular_velocity.isZero(0)) {
    pose.orientation = (TurnAbout(time * object.angular_velocity) * pose.orientation).normalized();
  }
  if (object.path == nullptr) return pose;
  pose.position = object.path->PositionAt(time);
  // The path is that of the origin.
  if (object.solid.compound != nullptr && !object.solid.compound->OriginToCentre().isZero(0))
    pose.position += pose.orientation * object.solid.compound->OriginToCentre();
  return pose;
}

InitialState DrawObjects(const plan::Scene& scene) {
  InitialState state;
  state.objects.reserve(scene.ObjectCount());
  objects::SolidFactory solids;
  for (std::size_t i = 0; i < scene.groups.size(); ++i) DrawGroup(scene, i, solids, state.objects);
  state.forms = solids.Forms();
  state.acceleration = distributions::Draw(scene, "acceleration").Vector();
  const double side = scene.world.Real("world.side");
  for (const ObjectState& object : state.objects)
    if (!analysis::SpawningOf(scene.groups[object.group]))
      state.fill_fraction += object.solid.Volume();
  state.fill_fraction /= side * side * side;
  return state;
}

InitialState MakeInitialState(const plan::Scene& scene) {
  InitialState state = DrawObjects(scene);
  Place(scene, state);
  return state;
}

void Displace(const plan::Scene& scene, InitialState& state) {
  distributions::Stream stream(scene.seeds.at("nudge"));
  for (ObjectState& object : state.objects) {
    const Eigen::Vector3d direction = stream.Turn() * Eigen::Vector3d::UnitX();
    if (object.IsFixed()) continue;
    object.pose.position += analysis::kDisplacement * object.solid.sides.maxCoeff() * direction;
  }
}

}  // namespace cdb::layouts
