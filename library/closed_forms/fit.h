// The conditions of closed forms on a scene, and the messages when one is violated.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/closed_forms/closed_form.h"

namespace cdb::closed_forms {

/// Two numbers of a scene count as equal within this relative difference.
inline constexpr double kSame = 1e-9;
/// The maximum height above the floor, as a fraction of its own height, at which an object still
/// counts as standing.
inline constexpr double kStandingGap = 0.01;
inline constexpr double kBallInertia = 0.4;  ///< I/(m r²)

/// A scene, checked for one form. Each Require throws SceneError if its condition is violated.
/// Scene and state must outlive it. SI units.
class Fit {
 public:
  /// Checks the requirements common to all forms: objects, none fixed, no schedules, links only in
  /// forms of linked objects, and the defaults of parameters that no form takes into account
  /// (schema::Parameter::closed_forms_need_default).
  Fit(std::string_view form, const plan::Scene& scene, const layouts::InitialState& state);

  /// Reports that `what` violates the form; `remedy` would fix it.
  [[noreturn]] void Refuse(const std::string& what, const std::string& remedy) const;

  std::size_t size() const { return state_.objects.size(); }
  const std::vector<layouts::ObjectState>& objects() const { return state_.objects; }
  const layouts::ObjectState& object(std::size_t index) const { return state_.objects[index]; }
  const Eigen::Vector3d& acceleration() const { return state_.acceleration; }
  double end() const { return end_; }  ///< of the run, including warm-up
  /// The settings of the first object's group.
  const plan::GroupSettings& links() const { return scene_.groups[object(0).group].settings; }
  /// The coordinate of the walls along `axis` on the side of `sign`, and whether there is a wall.
  double WallAt(int sign) const { return sign * half_; }
  bool HasWall(int axis, int sign) const;
  double WallFriction() const { return scene_.world.Real("world.wall_friction"); }
  double WallRestitution() const { return scene_.world.Real("world.wall_restitution"); }
  /// For messages: `object 3 of 10 (group `pebbles`)`.
  std::string Name(std::size_t index) const;

  void RequireOneObject() const;
  void RequireBall(std::size_t index) const;
  void RequireNoSpin(std::size_t index) const;
  void RequireNoVelocity(std::size_t index) const;
  void RequireNoAcceleration() const;
  /// Requires a floor, and an acceleration straight down onto it.
  void RequireFloor() const;
  void RequireLevelFloor() const;
  /// Requires that it moves along the floor.
  void RequireLevelVelocity(std::size_t index) const;
  /// Requires a link of the first object to the world, of one of the `types`: `ball or hinge`.
  void RequireLink(std::string_view types) const;
  /// Requires a cuboid with one axis upright. Returns this axis, whose side is the height.
  int RequireLevelCuboid(std::size_t index) const;
  /// Requires that the object, of this height, is `gap` above its support.
  void RequireStanding(std::size_t index, double gap, double height) const;
  /// True if a point below the middle of a level cuboid, displaced by `off` in world axes, is over
  /// the face that it stands on.
  bool IsOverBase(std::size_t index, int upright, const Eigen::Vector3d& off) const;
  /// Requires that the object, which extends from its centre as `box` does, reaches no wall on its
  /// path from `from` under constant acceleration in `seconds`.
  void RequireClearOfWalls(std::size_t index, const objects::Box& box, const Eigen::Vector3d& from,
                           const Eigen::Vector3d& velocity, const Eigen::Vector3d& acceleration,
                           double seconds) const;
  /// The component of the acceleration along the floor.
  Eigen::Vector3d Downhill() const { return {acceleration().x(), 0, acceleration().z()}; }
  double Pressing() const { return -acceleration().y(); }

 private:
  std::string form_;
  const plan::Scene& scene_;
  const layouts::InitialState& state_;
  double end_, half_;
};

/// The box around the object in any orientation or, if it does not spin, in its own.
objects::Box ReachOf(const layouts::ObjectState& object);

struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< about the common centre of mass
};
/// Momenta of objects that keep the orientation of the start, or are balls. `spins` is empty if
/// none spins.
Momenta MomentaOf(const std::vector<layouts::ObjectState>& objects,
                  const std::vector<Eigen::Vector3d>& positions,
                  const std::vector<Eigen::Vector3d>& velocities,
                  const std::vector<Eigen::Vector3d>& spins);

}  // namespace cdb::closed_forms
