#include "runtime/engine/world/axis_drive.h"

#include <algorithm>
#include <cmath>

#include "dsl/text/check.h"

namespace cdb::world {
namespace {

void Put(const btVector3& vector, btScalar* row) {
  for (int i = 0; i < 3; ++i) row[i] = vector[i];
}

}  // namespace

AxisDrive::AxisDrive(btRigidBody& first, btRigidBody& second, const Settings& settings,
                     const btVector3& axis_in_first, const btVector3& pivot_in_first,
                     const btVector3& pivot_in_second)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, first, second),
      settings_(settings),
      axis_in_first_(axis_in_first),
      pivot_in_first_(pivot_in_first),
      pivot_in_second_(pivot_in_second) {
  btVector3 other;
  btPlaneSpace1(axis_in_first_, across_in_first_, other);
  across_in_second_ = first.getWorldTransform().getBasis() * across_in_first_ *
                      second.getWorldTransform().getBasis();
}

btScalar AxisDrive::Position() const {
  const btTransform &first = m_rbA.getWorldTransform(), &second = m_rbB.getWorldTransform();
  const btVector3 axis = first.getBasis() * axis_in_first_;
  if (!settings_.turns) return axis.dot(second * pivot_in_second_ - first * pivot_in_first_);
  const btVector3 from = first.getBasis() * across_in_first_;
  const btVector3 to = second.getBasis() * across_in_second_;
  const btScalar angle = btAtan2(axis.dot(from.cross(to)), from.dot(to));
  return angle + SIMD_2_PI * std::round((last_ - angle) / SIMD_2_PI);
}

double AxisDrive::Excess() const {
  if (!settings_.HasLimits()) return 0;
  const auto position = static_cast<double>(Position());
  return std::max({0., settings_.lower - position, position - settings_.upper});
}

void AxisDrive::getInfo1(btConstraintInfo1* info) {
  info->m_numConstraintRows = (settings_.damping != 0 ? 1 : 0) + (settings_.friction != 0 ? 1 : 0) +
                              (settings_.effort != 0 ? 1 : 0) + (settings_.HasLimits() ? 2 : 0);
  info->nub = 0;
}

void AxisDrive::ListRows(const Moment& moment, RowList& list) {
  last_ = Position();
  if (settings_.damping != 0) {
    const auto damping = static_cast<btScalar>(settings_.damping);
    const btScalar impulse = -damping * moment.rate / moment.fps;
    const bool may_reverse = damping * moment.mobility > moment.fps;
    list.Add(may_reverse ? Row{0, std::min(impulse, btScalar(0)), std::max(impulse, btScalar(0))}
                         : Row{0, impulse, impulse});
  }
  if (settings_.friction != 0) {
    const btScalar most = static_cast<btScalar>(settings_.friction) / moment.fps;
    list.Add({0, -most, most});
  }
  if (settings_.effort != 0) {
    const btScalar most = static_cast<btScalar>(settings_.effort) / moment.fps;
    const btScalar velocity =
        settings_.target
            ? (static_cast<btScalar>(*settings_.target) - last_) * moment.erp * moment.fps
            : static_cast<btScalar>(settings_.velocity);
    list.Add({velocity, -most, most});
  }
  if (!settings_.HasLimits()) return;
  const auto approach = [&](double limit, btScalar inside) {
    const btScalar room = static_cast<btScalar>(limit) - last_;
    return (room * inside < 0 ? moment.erp : btScalar(1)) * room * moment.fps;
  };
  list.Add({approach(settings_.lower, -1), 0, SIMD_INFINITY});
  list.Add({approach(settings_.upper, 1), -SIMD_INFINITY, 0});
}

void AxisDrive::getInfo2(btConstraintInfo2* info) {
  const btTransform &first = m_rbA.getWorldTransform(), &second = m_rbB.getWorldTransform();
  const btVector3 axis = first.getBasis() * axis_in_first_, point = second * pivot_in_second_;
  const btVector3 linear = settings_.turns ? btVector3(0, 0, 0) : axis;
  const btVector3 of_first = settings_.turns ? axis : (point - first.getOrigin()).cross(axis);
  const btVector3 of_second = settings_.turns ? axis : (point - second.getOrigin()).cross(axis);
  const btScalar rate = linear.dot(m_rbB.getLinearVelocity() - m_rbA.getLinearVelocity()) +
                        of_second.dot(m_rbB.getAngularVelocity()) -
                        of_first.dot(m_rbA.getAngularVelocity());
  // If nothing else holds the two bodies.
  const btScalar mobility = linear.length2() * (m_rbA.getInvMass() + m_rbB.getInvMass()) +
                            of_first.dot(m_rbA.getInvInertiaTensorWorld() * of_first) +
                            of_second.dot(m_rbB.getInvInertiaTensorWorld() * of_second);
  RowList list;
  ListRows({.rate = rate, .mobility = mobility, .fps = info->fps, .erp = info->erp}, list);
  for (int i = 0; i < list.count; ++i) {
    const int at = i * info->rowskip;
    Put(-linear, info->m_J1linearAxis + at);
    Put(-of_first, info->m_J1angularAxis + at);
    Put(linear, info->m_J2linearAxis + at);
    Put(of_second, info->m_J2angularAxis + at);
    info->m_constraintError[at] = list.rows[i].velocity;
    info->m_lowerLimit[at] = list.rows[i].least;
    info->m_upperLimit[at] = list.rows[i].most;
  }
}

void AxisDrive::setParam(int, btScalar, int) { CDB_CHECK(false); }
btScalar AxisDrive::getParam(int, int) const { CDB_CHECK(false); }

}  // namespace cdb::world
