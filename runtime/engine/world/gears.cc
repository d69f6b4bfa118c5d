#include "runtime/engine/world/gears.h"

#include <algorithm>

#include "dsl/text/check.h"
#include "runtime/engine/world/axis_drive.h"

namespace cdb::world {
namespace {

btRigidBody& MovingOf(const JointAxis& axis) {
  return axis.second().isStaticOrKinematicObject() ? axis.first() : axis.second();
}

}  // namespace

btScalar Gear::BeginStep(btScalar erp, btScalar fps) {
  driven_.BeginStep();
  driver_.BeginStep();
  return -erp * fps * Error();
}

Gear::Shares Gear::ListShares() const {
  Shares shares;
  const auto add = [&](const JointAxis& axis, btScalar factor) {
    for (const JointAxis::Share& share : axis.Shares()) {
      int at = 0;
      while (at < shares.count && shares.of[at].body != share.body) ++at;
      if (at == shares.count)
        shares.of[shares.count++] = {share.body, btVector3(0, 0, 0), btVector3(0, 0, 0)};
      shares.of[at].linear += factor * share.linear;
      shares.of[at].angular += factor * share.angular;
    }
  };
  add(driven_, 1);
  add(driver_, -ratio_);
  return shares;
}

// Each joint keeps its own bodies in one island; one of each joint is joined here.
GearConstraint::GearConstraint(Gear& gear)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, MovingOf(gear.driven()), MovingOf(gear.driver())),
      gear_(gear) {}

void GearConstraint::getInfo1(btConstraintInfo1* info) {
  info->m_numConstraintRows = 0;
  info->nub = 0;
}
void GearConstraint::getInfo2(btConstraintInfo2*) { CDB_CHECK(false); }
void GearConstraint::setParam(int, btScalar, int) { CDB_CHECK(false); }
btScalar GearConstraint::getParam(int, int) const { CDB_CHECK(false); }

btScalar DriveSolver::solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                                    const btContactSolverInfo& info) {
  const btTypedConstraint* last = nullptr;
  int row = 0;
  for (int i = 0; is_watching_ && i < m_tmpSolverNonContactConstraintPool.size(); ++i) {
    const btSolverConstraint& solved = m_tmpSolverNonContactConstraintPool[i];
    auto* constraint = static_cast<btTypedConstraint*>(solved.m_originalContactPoint);
    row = constraint == last ? row + 1 : 0;
    last = constraint;
    if (constraint != nullptr && constraint->getUserConstraintType() == AxisDrive::kUserType)
      static_cast<AxisDrive*>(constraint)->TakeImpulse(row, solved.m_appliedImpulse);
  }
  return btSequentialImpulseConstraintSolver::solveGroupCacheFriendlyFinish(bodies, body_count,
                                                                            info);
}

btScalar GearSolver::solveGroupCacheFriendlySetup(
    btCollisionObject** bodies, int body_count, btPersistentManifold** manifolds,
    int manifold_count, btTypedConstraint** constraints, int constraint_count,
    const btContactSolverInfo& info, btIDebugDraw* draw) {
  const btScalar residual = btSequentialImpulseConstraintSolver::solveGroupCacheFriendlySetup(
      bodies, body_count, manifolds, manifold_count, constraints, constraint_count, info, draw);
  rows_.clear();
  for (int i = 0; i < constraint_count; ++i)
    if (auto* gear = dynamic_cast<GearConstraint*>(constraints[i])) AddRow(gear->gear(), info);
  return residual;
}

void GearSolver::AddRow(Gear& gear, const btContactSolverInfo& info) {
  Row row;
  row.shares = gear.ListShares();
  row.velocity = gear.BeginStep(info.m_erp, 1 / info.m_timeStep);
  btScalar mobility = 0;
  for (int i = 0; i < row.shares.count; ++i) {
    const JointAxis::Share& share = row.shares.of[i];
    row.bodies[i] = getOrInitSolverBody(*share.body, info.m_timeStep);
    if (!share.body->isStaticOrKinematicObject()) mobility += share.Mobility();
  }
  row.inverse = mobility > 0 ? 1 / mobility : btScalar(0);
  rows_.push_back(row);
}

btScalar GearSolver::Apply(const Row& row) {
  btScalar rate = 0;
  for (int i = 0; i < row.shares.count; ++i) {
    const btSolverBody& body = m_tmpSolverBodyPool[row.bodies[i]];
    const JointAxis::Share& share = row.shares.of[i];
    rate += share.linear.dot(body.m_linearVelocity + body.m_externalForceImpulse +
                             body.m_deltaLinearVelocity) +
            share.angular.dot(body.m_angularVelocity + body.m_externalTorqueImpulse +
                              body.m_deltaAngularVelocity);
  }
  const btScalar impulse = (row.velocity - rate) * row.inverse;
  for (int i = 0; i < row.shares.count; ++i) {
    const JointAxis::Share& share = row.shares.of[i];
    if (share.body->isStaticOrKinematicObject()) continue;
    m_tmpSolverBodyPool[row.bodies[i]].internalApplyImpulse(
        share.linear * share.body->getInvMass(),
        share.body->getInvInertiaTensorWorld() * share.angular, impulse);
  }
  return impulse * impulse;
}

btScalar GearSolver::solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                          btPersistentManifold** manifolds, int manifold_count,
                                          btTypedConstraint** constraints, int constraint_count,
                                          const btContactSolverInfo& info, btIDebugDraw* draw) {
  btScalar residual = 0;
  for (const Row& row : rows_) residual = std::max(residual, Apply(row));
  return std::max(residual, btSequentialImpulseConstraintSolver::solveSingleIteration(
                                iteration, bodies, body_count, manifolds, manifold_count,
                                constraints, constraint_count, info, draw));
}

}  // namespace cdb::world
