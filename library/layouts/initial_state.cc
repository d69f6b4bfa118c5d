#include "library/layouts/initial_state.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <string_view>

#include "compiler/plan/kinematic.h"
#include "library/distributions/draw.h"
#include "library/layouts/placement.h"
#include "library/layouts/pose_table.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"

namespace cdb::layouts {
namespace {

using Eigen::Vector3d;

/// The parameter is set by this word: `size same(…)`, `mass density(…)`.
bool IsBy(std::string_view word, const schema::Value& value) {
  const schema::Call* call = schema::AsCall(value);
  return call != nullptr && call->name == word;
}

Vector3d DrawSize(distributions::Draw& size, bool is_same) {
  // A constant size is the same for each side; a distribution draws each side by itself.
  const double x = size.Real();
  if (is_same) return Vector3d::Constant(x);
  const double y = size.Real();
  return {x, y, size.Real()};
}

Eigen::Quaterniond DrawOrientation(distributions::Draw& orientation) {
  std::string_view word;
  const auto turn = orientation.VectorOrWord(&word);
  return turn ? TurnAbout(*turn) : orientation.stream().Turn();
}

/// The body's own axes, when the object is turned so.
Eigen::Quaterniond BodyTurn(const objects::Solid& solid, const Eigen::Quaterniond& turn) {
  if (solid.compound == nullptr) return turn;
  const Eigen::Matrix3d to_mesh = solid.compound->from_mesh().transpose();
  return turn * Eigen::Quaterniond(to_mesh);
}

/// Positions too: the layout only checks them.
void TakeTable(const plan::Group& group, std::span<ObjectState> objects) {
  const schema::Call* poses = plan::PosesOf(group);
  if (poses == nullptr || objects.empty()) return;
  const PoseTable table = ReadPoseTable(*poses);
  if (table.rows.size() != objects.size())
    throw library::SceneError(fmt::format("group `{}` has {} objects, and its file the poses of {}",
                                          group.name, objects.size(), table.rows.size()),
                              "leave the quantity out, or name another file", group.name);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const PoseRow& row = table.rows[i];
    ObjectState& object = objects[i];
    object.pose.position = row.position;
    if (table.has_orientation)
      object.pose.orientation =
          table.of_body ? row.orientation : BodyTurn(object.solid, row.orientation);
    if (table.has_linear_velocity) object.linear_velocity = row.linear_velocity;
    if (table.has_angular_velocity) object.angular_velocity = row.angular_velocity;
  }
}

/// The pose too: the one at the start.
void TakePath(const plan::Group& group, std::span<ObjectState> objects) {
  const schema::Call* call = plan::PathOf(group);
  if (call == nullptr || objects.empty()) return;
  const auto path = std::make_shared<const Path>(ReadPath(*call));
  for (ObjectState& object : objects) {
    if (!object.is_kinematic)
      throw library::SceneError(
          fmt::format("the objects of group `{}` have a path and are not kinematic", group.name),
          "write mass kinematic", group.name);
    object.path = path;
    object.pose = PoseAt(object, 0);
  }
}

void DrawGroup(const plan::Scene& scene, std::size_t index, objects::SolidFactory& solids,
               std::vector<ObjectState>& objects) {
  const plan::Group& group = scene.groups[index];
  const auto draw = [&](schema::ParameterRef<true, schema::ValueKind::kDrawn> parameter) {
    return distributions::Draw(scene, group, parameter);
  };
  const Vector3d aspect = std::get<schema::Ratio>(group.settings.Get("aspect")).parts;
  distributions::Draw type = draw("type"), size = draw("size"), mass = draw("mass");
  distributions::Draw orientation = draw("orientation");
  distributions::Draw linear_velocity = draw("linear_velocity"),
                      angular_velocity = draw("angular_velocity");
  distributions::Draw friction = draw("friction"), rolling_friction = draw("rolling_friction");
  distributions::Draw restitution = draw("restitution");
  distributions::Draw linear_damping = draw("linear_damping"),
                      angular_damping = draw("angular_damping");
  distributions::Draw margin = draw("margin"), ccd = draw("ccd");
  distributions::Draw contact_stiffness = draw("contact_stiffness"),
                      contact_damping = draw("contact_damping");
  const bool is_same = IsBy("same", group.settings.Get("size"));
  const bool by_density = IsBy("density", group.settings.Get("mass"));
  const std::uint64_t quantity = group.settings.Count("quantity");
  for (std::uint64_t i = 0; i < quantity; ++i) {
    ObjectState& object = objects.emplace_back();
    std::string_view word;
    object.group = index;
    const schema::Value& chosen = type.Choice();
    object.solid = solids.Make(chosen, DrawSize(size, is_same), aspect);
    object.mass = mass.RealOrWord(&word).value_or(0);  // the word is `fixed` or `kinematic`
    object.is_kinematic = object.mass == 0 && word == plan::kKinematicWord;
    if (by_density) object.mass *= object.solid.Volume();
    object.pose.orientation = BodyTurn(object.solid, DrawOrientation(orientation));
    object.linear_velocity = linear_velocity.Vector();
    object.angular_velocity = angular_velocity.Vector();
    object.friction = friction.Real();
    object.rolling_friction = rolling_friction.Real();
    object.restitution = restitution.Real();
    object.linear_damping = linear_damping.Real();
    object.angular_damping = angular_damping.Real();
    object.margin = margin.Real();
    object.ccd = ccd.On();
    // The word is `rigid`.
    object.contact_stiffness =
        contact_stiffness.RealOrWord(&word).value_or(std::numeric_limits<double>::infinity());
    object.contact_damping = contact_damping.Real();
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
  if (object.path != nullptr) {
    pose.position = object.path->PositionAt(time);
  } else {
    pose.position += time * object.linear_velocity;
  }
  if (object.path != nullptr && object.path->has_orientation()) {
    pose.orientation = BodyTurn(object.solid, object.path->OrientationAt(time));
  } else if (!object.angular_velocity.isZero(0)) {
    pose.orientation = (TurnAbout(time * object.angular_velocity) * pose.orientation).normalized();
  }
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
  for (const ObjectState& object : state.objects) state.fill_fraction += object.solid.Volume();
  state.fill_fraction /= side * side * side;
  return state;
}

InitialState MakeInitialState(const plan::Scene& scene) {
  InitialState state = DrawObjects(scene);
  Place(scene, state);
  return state;
}

}  // namespace cdb::layouts
