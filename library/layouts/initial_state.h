// The initial state of a scene: every object, drawn and placed. In double and from the plan alone,
// so that it is the same for every precision, detector and machine.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/path.h"
#include "library/objects/solid.h"

namespace cdb::layouts {

/// One object. SI units.
struct ObjectState {
  std::size_t group = 0;  ///< index into Scene::groups
  objects::Solid solid;
  objects::Pose pose;  ///< of the body's own axes, which for a compound are not its mesh's
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  double mass = 1;  ///< 0 where the object is fixed or kinematic
  double friction = 0;
  double rolling_friction = 0;
  double restitution = 0;
  double linear_damping = 0;
  double angular_damping = 0;
  double margin = 0;
  double contact_stiffness = std::numeric_limits<double>::infinity();  ///< infinite: rigid
  double contact_damping = 0;
  bool ccd = false;
  /// It moves by its velocities, or its path, whatever it meets.
  bool is_kinematic = false;
  std::shared_ptr<const Path> path = nullptr;  ///< of a kinematic object; null: none

  /// Nothing that it meets moves it; a kinematic object moves all the same.
  bool IsFixed() const { return mass == 0; }
};

struct InitialState {
  std::vector<ObjectState> objects;  ///< group by group, in the order of the plan
  std::vector<std::shared_ptr<const objects::ConvexDecomposition>>
      forms;  ///< of the compounds among them
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  double fill_fraction = 0;  ///< the objects' volume over the cube's
};

/// Draws and places. Throws SceneError where a distribution gives no usable value, an object does
/// not fit into the cube, or no free place is found (layouts/placement.h).
InitialState MakeInitialState(const plan::Scene& scene);

/// The objects without a place, and the acceleration: the first half of MakeInitialState.
InitialState DrawObjects(const plan::Scene& scene);

/// Where a kinematic object is `time` s after the start: on its path, or as far as its velocities,
/// which are constant, have taken it. Without columns of orientation, the object of a path turns by
/// its angular velocity.
objects::Pose PoseAt(const ObjectState& object, double time);

/// `objects.orientation`, which turns the sides' axes: a turn about the vector's direction by its
/// length, rad. std::sin and std::cos decide the last bit.
Eigen::Quaterniond TurnAbout(const Eigen::Vector3d& rotation_vector);

}  // namespace cdb::layouts
