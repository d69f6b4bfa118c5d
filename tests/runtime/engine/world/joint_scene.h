// Scenes of cuboids and joints in free space, in maximal and in reduced coordinates.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "tests/runtime/engine/engine_fixture.h"

namespace cdb::tests {

/// The parameter: `maximal` or `reduced`.
class InCoordinates : public testing::TestWithParam<const char*> {
 protected:
  bool IsReduced() const { return GetParam() == std::string("reduced"); }
  /// Cuboids of 1 m and 1 kg in free space, without weight; the group `objects` has one at the
  /// origin.
  plan::Scene JointScene(double rate = 240) const {
    plan::Scene scene = EngineScene(1, 1000);
    SetWorld(scene, "coordinates", Word(GetParam()));
    SetWorld(scene, "world.walls", Word("none"));
    SetWorld(scene, "acceleration", Eigen::Vector3d(0, 0, 0));
    SetWorld(scene, "sleeping", false);
    SetWorld(scene, "timestep", 1 / rate);
    SetGroup(scene, "type", Word("cuboid"));
    SetGroup(scene, "size", 1.0);
    SetGroup(scene, "location", Layout("at", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}));
    return scene;
  }
};

/// A group like the first one, at another place. Returns its index.
inline std::size_t AddPart(plan::Scene& scene, const std::string& name,
                           const schema::Value& location) {
  scene.groups.push_back({name, scene.groups[0].settings});
  scene.groups.back().settings.Set("location", location);
  return scene.groups.size() - 1;
}

inline schema::Value PlaceAt(double x, double y, double z) {
  return Layout("at", {{"x", x}, {"y", y}, {"z", z}});
}

/// Joints are named joint0, joint1 and so on.
inline plan::GroupSettings& AddJoint(plan::Scene& scene, std::string_view type,
                                     std::string_view parent, std::string_view child,
                                     const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
  plan::GroupSettings& settings =
      scene.joints.emplace_back(plan::Joint{"joint" + std::to_string(scene.joints.size()), {}})
          .settings;
  settings.Set("joints.type", Word(type));
  settings.Set("joints.parent", Word(parent));
  settings.Set("joints.child", Word(child));
  settings.Set("joints.at", at);
  return settings;
}

inline world::Engine EngineOfJoints(const plan::Scene& scene) {
  return WholeEngine(scene, layouts::MakeInitialState(scene));
}

inline Eigen::Vector3d SpinOf(const world::Engine& engine, std::size_t object = 0) {
  return ToEigen(engine.objects()[object]->getAngularVelocity());
}

/// Of a cuboid of 1 m and 1 kg, kg m^2.
constexpr double kInertiaOfCube = 1.0 / 6;

inline Eigen::Matrix3d InertiaOf(const btRigidBody& body) {
  return world::ToEigen(body.getInvInertiaTensorWorld()).inverse();
}

/// Of cuboids of 1 kg, with the energy of rotation, J.
inline double WholeEnergy(const world::Engine& engine) {
  double energy = 0;
  for (std::size_t i = 0; i < engine.objects().size(); ++i) {
    const Eigen::Vector3d spin = SpinOf(engine, i);
    energy +=
        (Velocity(engine, i).squaredNorm() + spin.dot(InertiaOf(*engine.objects()[i]) * spin)) / 2;
  }
  return energy;
}

/// About the origin, of all objects that move.
inline Eigen::Vector3d MomentumOf(const world::Engine& engine) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& body : engine.objects())
    if (!body->isStaticOrKinematicObject())
      sum +=
          ToEigen(body->getWorldTransform().getOrigin()).cross(ToEigen(body->getLinearVelocity())) /
              static_cast<double>(body->getInvMass()) +
          InertiaOf(*body) * ToEigen(body->getAngularVelocity());
  return sum;
}

}  // namespace cdb::tests
