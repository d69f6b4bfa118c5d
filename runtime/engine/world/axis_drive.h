// The damping, the motor and the limits of a hinge or a slider.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <optional>

#include "runtime/engine/world/joint_axis.h"

namespace cdb::world {

/// Acts on the position q of a hinge or a slider, which is 0 at the start. SI units; impulses of a
/// step are those of a force F times dt.
///
///   damping  -c dq/dt with the state at the start of the step; where that could reverse the motion
///            of the two bodies, at most what stops it
///   friction whatever makes dq/dt 0, up to the friction
///   motor    whatever makes dq/dt the velocity, up to the effort; with a target, the velocity by
///            which the solver's error reduction approaches it; or a torque, whatever moves
///   limits   what keeps q within them after the step, inelastically; what is beyond a limit is
///            corrected by the solver's error reduction
///
/// Not thread-safe.
class AxisDrive : public btTypedConstraint {
 public:
  struct Settings {
    double damping = 0;
    double friction = 0;
    double velocity = 0, effort = 0;    ///< no motor if the effort is 0
    std::optional<double> target = {};  ///< of q, for the motor
    std::optional<double> torque = {};  ///< N m, or N, of the motor, instead of what it seeks
    double lower = 1, upper = -1;       ///< no limits if lower > upper

    bool HasLimits() const { return lower <= upper; }
    bool IsIdle() const {
      return damping == 0 && friction == 0 && effort == 0 && !torque && !HasLimits();
    }
  };

  /// Of btTypedConstraint::getUserConstraintType.
  static constexpr int kUserType = 0x61786973;

  /// The axis must outlive it.
  AxisDrive(JointAxis& axis, const Settings& settings);

  /// Whether a motor seeks something.
  bool HasMotor() const { return settings_.effort != 0; }
  /// Of the steps from now on: its velocity, target or torque, whichever it has.
  void SetGoal(double goal) {
    (settings_.torque   ? *settings_.torque
     : settings_.target ? *settings_.target
                        : settings_.velocity) = goal;
  }
  bool GivesTorque() const { return settings_.torque.has_value(); }
  double torque() const { return settings_.torque.value_or(0); }
  /// What the solver gave to a row of the step, by its index.
  void TakeImpulse(int row, btScalar impulse) {
    if (row == motor_.row) motor_.impulse = impulse;
  }
  /// By how far the motor missed in the last step what it seeks, although it had effort left: of a
  /// velocity, as a fraction of it; of a position, rad, or m over `length`. A limit that the joint
  /// would pass is no miss. Nullopt if there was no step since the last call, and for the velocity
  /// 0, which has no scale.
  std::optional<double> TakeMiss(double length);

  /// How far q is past a limit; 0 within.
  double Excess() const;

  /// A row of a constraint: the velocity dq/dt that it seeks, and the impulses that it may use.
  struct Row {
    btScalar velocity, least, most;
  };
  struct RowList {
    static constexpr int kMost = 6;
    Row rows[kMost];
    int count = 0;
    void Add(const Row& row) { rows[count++] = row; }
  };
  /// At the start of a step.
  struct Moment {
    btScalar rate;      ///< dq/dt
    btScalar mobility;  ///< the velocity that a unit impulse gives the joint
    btScalar fps;       ///< 1/s
    btScalar erp;       ///< error reduction of the solver
  };
  /// The rows of the step that begins now, with q by the poses of the bodies.
  void ListRows(const Moment& moment, RowList& list);

  void getInfo1(btConstraintInfo1* info) override;
  void getInfo2(btConstraintInfo2* info) override;
  void setParam(int num, btScalar value, int axis) override;
  btScalar getParam(int num, int axis) const override;

 private:
  /// Of the last step.
  struct Motor {
    int row = -1;  ///< -1: no step
    btScalar position = 0, sought = 0, most = 0, impulse = 0;
    btScalar fps = 0, erp = 0;
  };

  JointAxis& axis_;
  Settings settings_;
  Motor motor_;
};

}  // namespace cdb::world
