#include "runtime/engine/world/kinematics.h"

#include <Eigen/Geometry>

#include "runtime/engine/world/conversions.h"

namespace cdb::world {
namespace {

/// The constant spin, rad/s, that turns one orientation into another in `seconds`, the shorter way.
Eigen::Vector3d SpinBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to,
                            double seconds) {
  const Eigen::AngleAxisd turn(to * from.conjugate());
  return turn.angle() / seconds * turn.axis();
}

btQuaternion QuaternionOf(const Eigen::Quaterniond& turn) {
  return {static_cast<btScalar>(turn.x()), static_cast<btScalar>(turn.y()),
          static_cast<btScalar>(turn.z()), static_cast<btScalar>(turn.w())};
}

}  // namespace

Kinematics::Kinematics(const plan::Scene& scene, Engine& engine)
    : engine_(engine), timestep_(scene.world.Real("timestep")) {
  const auto& objects = engine.initial_state().objects;
  for (std::size_t i = 0; i < objects.size(); ++i)
    if (objects[i].is_kinematic) objects_.push_back(i);
}

void Kinematics::BeforeStep(std::uint64_t step) const {
  for (const std::size_t i : objects_) {
    const layouts::ObjectState& object = engine_.initial_state().objects[i];
    const objects::Pose from = layouts::PoseAt(object, TimeOf(step));
    const objects::Pose to = layouts::PoseAt(object, TimeOf(step + 1));
    // A constant spin is used directly: beyond half a turn per step, the poses would not determine
    // it.
    const bool is_told = object.path != nullptr && object.path->has_orientation();
    btRigidBody& body = *engine_.objects()[i];
    body.setLinearVelocity(ToBullet((to.position - from.position) / timestep_));
    body.setAngularVelocity(ToBullet(is_told
                                         ? SpinBetween(from.orientation, to.orientation, timestep_)
                                         : object.angular_velocity));
  }
}

void Kinematics::AfterStep(std::uint64_t step) const {
  for (const std::size_t i : objects_) {
    const objects::Pose pose =
        layouts::PoseAt(engine_.initial_state().objects[i], TimeOf(step + 1));
    btRigidBody& body = *engine_.objects()[i];
    const btTransform transform(QuaternionOf(pose.orientation), ToBullet(pose.position));
    body.setWorldTransform(transform);
    body.setInterpolationWorldTransform(transform);
  }
}

}  // namespace cdb::world
