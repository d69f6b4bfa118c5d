// Gears: couplings of the positions of two joints.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <vector>

#include "runtime/engine/world/joint_axis.h"

namespace cdb::world {

/// Keeps the position of the driven joint at `ratio` times that of the driver, both counted from
/// the start, by an impulse that acts on both joints, and so on up to four bodies: the carrier of
/// two wheels takes what they do not. What has opened is corrected by the solver's error reduction.
///
/// Bullet's btGearConstraint compares the spins of two bodies in the world, as if what carries them
/// stood still, and corrects no angle; btMultiBodyGearConstraint needs both joints in multibodies
/// and knows no loops. Neither is used.
class Gear {
 public:
  /// The axes must outlive it.
  Gear(JointAxis& driven, JointAxis& driver, double ratio)
      : driven_(driven), driver_(driver), ratio_(static_cast<btScalar>(ratio)) {}

  const JointAxis& driven() const { return driven_; }
  const JointAxis& driver() const { return driver_; }
  /// Whether the driven joint turns: the unit of Error is rad, otherwise m.
  bool turns() const { return driven_.turns(); }
  /// The position of the driven joint less the one that it should have.
  btScalar Error() const { return driven_.Position() - ratio_ * driver_.Position(); }
  /// The velocity of Error that the step which begins now seeks. `fps`: 1/s.
  btScalar BeginStep(btScalar erp, btScalar fps);

  struct Shares {
    JointAxis::Share of[4];
    int count = 0;
  };
  /// Of each body in the velocity of Error; a body is listed once.
  Shares ListShares() const;

 private:
  JointAxis &driven_, &driver_;
  const btScalar ratio_;
};

/// Tells a world of a gear: its bodies are in one island, and GearSolver finds it. It has no rows
/// of its own, which Bullet limits to two bodies.
class GearConstraint final : public btTypedConstraint {
 public:
  explicit GearConstraint(Gear& gear);

  Gear& gear() { return gear_; }

  void getInfo1(btConstraintInfo1* info) override;
  void getInfo2(btConstraintInfo2* info) override;
  void setParam(int num, btScalar value, int axis) override;
  btScalar getParam(int num, int axis) const override;

 private:
  Gear& gear_;
};

/// Bullet's solver, which tells each AxisDrive the impulses of its rows if it watches. Not
/// thread-safe.
class DriveSolver : public btSequentialImpulseConstraintSolver {
 public:
  void Watch() { is_watching_ = true; }

 protected:
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                         const btContactSolverInfo& info) override;

 private:
  bool is_watching_ = false;
};

/// Bullet's solver, with the rows of gears: projected Gauss-Seidel as for its own rows, before
/// these in each iteration. Not thread-safe.
class GearSolver final : public DriveSolver {
 protected:
  btScalar solveGroupCacheFriendlySetup(btCollisionObject** bodies, int body_count,
                                        btPersistentManifold** manifolds, int manifold_count,
                                        btTypedConstraint** constraints, int constraint_count,
                                        const btContactSolverInfo& info,
                                        btIDebugDraw* draw) override;
  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                btPersistentManifold** manifolds, int manifold_count,
                                btTypedConstraint** constraints, int constraint_count,
                                const btContactSolverInfo& info, btIDebugDraw* draw) override;

 private:
  struct Row {
    Gear::Shares shares;
    int bodies[4];      ///< in Bullet's pool, by share
    btScalar velocity;  ///< sought
    btScalar inverse;   ///< of the velocity that a unit impulse gives; 0 if nothing can move
  };
  void AddRow(Gear& gear, const btContactSolverInfo& info);
  /// Returns the square of the impulse that it applied.
  btScalar Apply(const Row& row);

  std::vector<Row> rows_;
};

}  // namespace cdb::world
