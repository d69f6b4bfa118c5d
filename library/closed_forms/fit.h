// The conditions of closed forms on a scene, and the messages when one is not met.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/closed_forms/closed_form.h"

namespace cdb::closed_forms {

/// Where two numbers of a scene count as the same, relative to their size.
inline constexpr double kSame = 1e-9;
/// Of an object's height: the most that it may stand above the floor and still count as standing.
inline constexpr double kStandingGap = 0.01;
inline constexpr double kBallInertia = 0.4;  ///< I/(m r²)

/// A scene, looked at by one form. Each Require throws SceneError where it is otherwise. Scene and
/// state must outlive it. SI units.
class Fit {
 public:
  /// Requires what every form does: objects, none fixed, none damped, nothing on a schedule, rigid
  /// contacts; and links only where the form is of them.
  Fit(std::string_view form, const plan::Scene& scene, const layouts::InitialState& state);

  /// `what` is so and is not of the form; `remedy` would be.
  [[noreturn]] void Refuse(const std::string& what, const std::string& remedy) const;

  std::size_t size() const { return state_.objects.size(); }
  const std::vector<layouts::ObjectState>& objects() const { return state_.objects; }
  const layouts::ObjectState& object(std::size_t index) const { return state_.objects[index]; }
  const Eigen::Vector3d& acceleration() const { return state_.acceleration; }
  double end() const { return end_; }  ///< of the run, warm-up included
  /// The settings of the first object's group.
  const plan::GroupSettings& links() const { return scene_.groups[object(0).group].settings; }
  /// The walls' coordinate along `axis` on the side of `sign`, and whether one stands there.
  double WallAt(int sign) const { return sign * half_; }
  bool HasWall(int axis, int sign) const;
  /// For messages: `object 3 of 10 (group `pebbles`)`.
  std::string Name(std::size_t index) const;

  void RequireOneObject() const;
  void RequireBall(std::size_t index) const;
  void RequireNoSpin(std::size_t index) const;
  void RequireNoVelocity(std::size_t index) const;
  void RequireNoAcceleration() const;
  /// A floor stands, and the acceleration presses onto it; straight down.
  void RequireFloor() const;
  void RequireLevelFloor() const;
  /// It moves along the floor.
  void RequireLevelVelocity(std::size_t index) const;
  /// The first object is linked to the world, by one of the `types`: `ball or hinge`.
  void RequireLink(std::string_view types) const;
  /// A cuboid with one axis upright. Gives that axis, whose side is its height.
  int RequireLevelCuboid(std::size_t index) const;
  /// The object, that tall, is `gap` above what it stands on.
  void RequireStanding(std::size_t index, double gap, double height) const;
  /// A point below the middle of a level cuboid, so far off it in the world's axes, is over the
  /// face that it stands on.
  bool IsOverBase(std::size_t index, int upright, const Eigen::Vector3d& off) const;
  /// No wall is reached by the object, which extends from its centre as `box` does, on its way from
  /// `from` under constant acceleration in `seconds`.
  void RequireClearOfWalls(std::size_t index, const objects::Box& box, const Eigen::Vector3d& from,
                           const Eigen::Vector3d& velocity, const Eigen::Vector3d& acceleration,
                           double seconds) const;
  /// The part of the acceleration along the floor.
  Eigen::Vector3d Downhill() const { return {acceleration().x(), 0, acceleration().z()}; }
  double Pressing() const { return -acceleration().y(); }

 private:
  std::string form_;
  const plan::Scene& scene_;
  const layouts::InitialState& state_;
  double end_, half_;
};

/// A box around the object that holds it however it turns, or, where it does not spin, just it.
objects::Box ReachOf(const layouts::ObjectState& object);

struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< about the common centre of mass
};
/// Of objects that are turned as they were at the start, or are balls. `spins` is empty where none
/// turns.
Momenta MomentaOf(const std::vector<layouts::ObjectState>& objects,
                  const std::vector<Eigen::Vector3d>& positions,
                  const std::vector<Eigen::Vector3d>& velocities,
                  const std::vector<Eigen::Vector3d>& spins);

// The forms, each in a file of its name: slide and stick in incline.cc, roll and bowl in
// ball_on_floor.cc, flip in spin.cc.
std::unique_ptr<ClosedForm> MakeFlight(const Fit& fit);
std::unique_ptr<ClosedForm> MakeBounce(const Fit& fit);
std::unique_ptr<ClosedForm> MakeSlide(const Fit& fit);
std::unique_ptr<ClosedForm> MakeStick(const Fit& fit);
std::unique_ptr<ClosedForm> MakeSpin(const Fit& fit);
std::unique_ptr<ClosedForm> MakeHeadOn(const Fit& fit);
std::unique_ptr<ClosedForm> MakeRolling(const Fit& fit);
std::unique_ptr<ClosedForm> MakeStack(const Fit& fit);
std::unique_ptr<ClosedForm> MakeBraking(const Fit& fit);
std::unique_ptr<ClosedForm> MakeRoll(const Fit& fit);
std::unique_ptr<ClosedForm> MakeBowl(const Fit& fit);
std::unique_ptr<ClosedForm> MakeOblique(const Fit& fit);
std::unique_ptr<ClosedForm> MakeSpring(const Fit& fit);
std::unique_ptr<ClosedForm> MakePendulum(const Fit& fit);
std::unique_ptr<ClosedForm> MakeFlip(const Fit& fit);

}  // namespace cdb::closed_forms
