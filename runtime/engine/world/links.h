// Joints and springs between the objects of a group, and joints between those of two groups.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "compiler/analysis/time_table.h"
#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/joint_pairs.h"
#include "runtime/engine/world/axis_drive.h"
#include "runtime/engine/world/gears.h"
#include "runtime/engine/world/motor_watch.h"
#include "runtime/engine/world/multibodies.h"

namespace cdb::world {

/// The links and joints of a scene, which are in its world as long as this lives. A link holds an
/// object to the next one of its group. With `links.anchor`, the first object is also held to a
/// point of the world, as if one more object preceded it: as far from it as the second (a single
/// object hangs from half its height above its centre of mass). A joint holds object i of a group
/// to object i of another (layouts::JointPairsOf). Two fixed objects are not linked. Linked objects
/// do not collide.
///
///   ball, hinge, fixed  btPoint2PointConstraint, btHingeConstraint (of links about the world's z),
///                       btFixedConstraint; the pivot of links is in the middle between the centres
///                       of mass
///   slider              btGeneric6DofSpring2Constraint, free along one axis
///   universal           UniversalJoint
///   spring              between the centres of mass, along a line that turns with the first of the
///                       two: the force is k x + c dx/dt with the state at the start of the step,
///                       neither limited nor softened, so that it explodes if w dt exceeds 2; the
///                       other object is held on the line by Bullet's
///                       btGeneric6DofSpring2Constraint and turns freely
/// The damping, the motor and the limits of a joint are rows of a constraint of their own,
/// AxisDrive; a gear is a row of GearSolver, which the world must have. In reduced coordinates,
/// joints are Multibodies instead, and the world has no such constraints. Not thread-safe.
class Links {
 public:
  /// `objects` are those of `state`, at their initial poses. World and objects must outlive it.
  /// Throws library::SceneError if a spring has no length, and so no line.
  Links(const plan::Scene& scene, const layouts::InitialState& state,
        const std::vector<std::unique_ptr<btRigidBody>>& objects, btDiscreteDynamicsWorld& world);
  ~Links();
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;

  bool HasJoints() const { return joints_; }
  /// Whether a motor gives a torque, or changes over time what it seeks.
  bool HasTimedMotors() const { return !timed_.empty(); }
  /// Call before and after each step, which begins at `time`, s. In a step, a motor gives the
  /// torque of its middle, and seeks what its table has at its end.
  void BeginStep(double time, double timestep);
  void EndStep(double timestep);
  /// J, of motors that give a torque, since the start.
  double Work() const { return work_; }
  /// J, of the rotors of joints with an armature.
  double RotorEnergy() const;
  /// Watches its motors from now on; null if it has none.
  std::unique_ptr<MotorWatch> WatchMotors() const;
  /// Null in maximal coordinates, and without joints.
  Multibodies* multibodies() const { return multibodies_.get(); }
  /// Whether a link pulls the object: its motion is not free.
  bool Holds(std::size_t object) const { return object < held_.size() && held_[object]; }
  /// Distances between the two pivots of a joint (of a slider, from its axis), or of a slider past
  /// its limits or from where its gear would have it, m, and what the first add up to along a chain
  /// of joints; 0 without joints.
  struct Gaps {
    double largest = 0, sum = 0;
    double stretch = 0;  ///< largest sum of the gaps of a chain over its length
    /// Largest angle, rad: of an object from where the first body of its chain would hold it by
    /// fixed joints, seen from that body's pivot; of the axes of a hinge from each other, and of
    /// those of a universal joint from a right angle; of what
    /// is held by a fixed joint or a slider, not by a link, from its orientation; of a hinge past
    /// its limits, or from where its gear would have it.
    double bend = 0;
  };
  Gaps MeasureGaps() const;
  /// The kinetic energy that perfect joints take at once, J, as velocities of the start that
  /// contradict them end in a jerk: with the Jacobian A of the joints and the velocities v, half of
  /// (A v)^T (A M^-1 A^T)^-1 A v.
  double JerkEnergy() const;
  /// The energy of all springs, k x^2 / 2, with the integrator's own term dt F.v / 2, J.
  double SpringEnergy(double timestep) const;

 private:
  struct Link {
    std::optional<JointKind> kind;  ///< nullopt: a spring
    std::unique_ptr<btTypedConstraint> constraint;
    std::unique_ptr<JointAxis> axis;   ///< of a joint that is a hinge or a slider
    std::unique_ptr<AxisDrive> drive;  ///< null without damping, motor and limits
    double armature = 0;               ///< kg m^2, or kg
    btRigidBody *first, *second;
    btVector3 pivot_in_first, pivot_in_second;  ///< m; for a spring, its ends
    btVector3 line_in_first;                    ///< unit vector of a spring, a hinge or a slider
    double length = 0;                          ///< m, of a spring at rest
    double stiffness = 0;                       ///< N/m; 0 for a joint
    std::size_t root = 0;                       ///< the first of the fixed ones that hold this one
    std::size_t before = 0;                     ///< the link that holds `first`, or itself
    double chain = 0;                           ///< m: length of the chain up to its end
    btVector3 second_in_root;                   ///< m: in the first body of the root, at the start
    /// The orientation of the second in the first at the start; nullopt if it is not watched.
    std::optional<btMatrix3x3> turn;
  };

  /// A motor that gives a torque, or has a table.
  struct TimedMotor {
    std::size_t link;
    double start = 0;  ///< of the joint, from which the drive counts a position
    std::optional<analysis::TimeTable> table = {};
    std::array<JointAxis::Share, 2> shares = {};  ///< before the step
    double rate = 0;
  };
  void AddTimedMotor(const plan::GroupSettings& settings);
  double BendOf(const Link& link) const;
  /// From the pivot of the first to that of the second, where they should be the same.
  Eigen::Vector3d GapOf(const Link& link) const;

  void AddLinks(const plan::Group& group, const layouts::ObjectState& object, std::size_t first,
                std::size_t end, const std::vector<std::unique_ptr<btRigidBody>>& objects);
  /// Between the pivots of the link.
  static void MakeBall(btRigidBody& first, btRigidBody& second, Link& link);
  /// `from`: the position of the first of the two, or where it would be.
  void AddLink(const plan::GroupSettings& settings, btRigidBody& first, btRigidBody& second,
               const btVector3& from);
  void AddJoint(const layouts::JointPair& pair, const layouts::InitialState& state,
                const std::vector<std::unique_ptr<btRigidBody>>& objects);
  /// `length`: of the chain, m.
  void Add(Link link, btRigidBody& first, btRigidBody& second, double length);

  /// Each with its own driver, or all with one.
  void AddGears(const std::vector<JointAxis*>& driven, const std::vector<JointAxis*>& drivers,
                double ratio);
  void MakeMultibodies(std::size_t objects);
  /// Of all links but springs.
  std::vector<JointFrame> ListFrames() const;
  std::vector<Gear*> ListGears() const;

  btDiscreteDynamicsWorld& world_;
  const bool is_reduced_;
  struct GearEntry {
    std::unique_ptr<Gear> gear;
    std::unique_ptr<GearConstraint> constraint;
  };
  std::vector<Link> links_;
  std::vector<GearEntry> gears_;
  std::vector<TimedMotor> timed_;
  double work_ = 0;
  std::unique_ptr<Multibodies> multibodies_;
  std::map<const btRigidBody*, std::size_t> holders_;  ///< the first link whose second it is
  std::vector<bool> held_;                             ///< by object, up to the last that is
  bool joints_ = false;
};

}  // namespace cdb::world
