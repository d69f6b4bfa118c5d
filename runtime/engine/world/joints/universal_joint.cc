#include "runtime/engine/world/joints/universal_joint.h"

namespace cdb::joints {

UniversalJoint::UniversalJoint(btRigidBody& first, btRigidBody& second,
                               const btVector3& pivot_in_first, const btVector3& pivot_in_second,
                               const btVector3& axis_in_first, const btVector3& axis_in_second)
    : btPoint2PointConstraint(first, second, pivot_in_first, pivot_in_second),
      axis_in_first_(axis_in_first),
      axis_in_second_(axis_in_second) {}

void UniversalJoint::getInfo1(btConstraintInfo1* info) {
  info->m_numConstraintRows = 4;
  info->nub = 2;
}

void UniversalJoint::getInfo2(btConstraintInfo2* info) {
  btPoint2PointConstraint::getInfo2(info);
  // d(a . b)/dt = (w_first - w_second) . (a x b)
  const btVector3 a = AxisOfFirst(), b = AxisOfSecond(), about = a.cross(b);
  const int row = 3 * info->rowskip;
  for (int i = 0; i < 3; ++i) {
    info->m_J1linearAxis[row + i] = info->m_J2linearAxis[row + i] = 0;
    info->m_J1angularAxis[row + i] = about[i];
    info->m_J2angularAxis[row + i] = -about[i];
  }
  info->m_constraintError[row] = -info->fps * info->erp * a.dot(b);
}

}  // namespace cdb::joints
