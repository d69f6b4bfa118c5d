#include "runtime/engine/world/axis_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsl/text/check.h"

namespace cdb::world {
namespace {

void Put(const btVector3& vector, btScalar* row) {
  for (int i = 0; i < 3; ++i) row[i] = vector[i];
}

}  // namespace

AxisDrive::AxisDrive(JointAxis& axis, const Settings& settings)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, axis.first(), axis.second()),
      axis_(axis),
      settings_(settings) {
  setUserConstraintType(kUserType);
}

double AxisDrive::Excess() const {
  if (!settings_.HasLimits()) return 0;
  const auto position = static_cast<double>(axis_.Position());
  return std::max({0., settings_.lower - position, position - settings_.upper});
}

std::optional<double> AxisDrive::TakeMiss(double length) {
  if (motor_.row < 0) return std::nullopt;
  const Motor motor = std::exchange(motor_, {});
  const double fps = static_cast<double>(motor.fps);
  double sought = static_cast<double>(motor.sought);
  if (settings_.HasLimits()) {
    const auto position = static_cast<double>(motor.position);
    sought = std::clamp(sought, std::min(0., (settings_.lower - position) * fps),
                        std::max(0., (settings_.upper - position) * fps));
  }
  const auto [first, second] = axis_.Shares();
  const double missing = sought - static_cast<double>(first.Rate() + second.Rate());
  // Rounding may leave it just below.
  constexpr double kWhole = 1 - 1e-5;
  const double whole = kWhole * static_cast<double>(motor.most);
  const auto impulse = static_cast<double>(motor.impulse);
  const bool is_spent = missing > 0 ? impulse >= whole : impulse <= -whole;
  if (settings_.target)
    return is_spent ? 0
                    : std::abs(missing) / (static_cast<double>(motor.erp) * fps) /
                          (axis_.turns() ? 1 : length);
  if (settings_.velocity == 0) return std::nullopt;
  return is_spent ? 0 : std::abs(missing / settings_.velocity);
}

void AxisDrive::getInfo1(btConstraintInfo1* info) {
  info->m_numConstraintRows = (settings_.damping != 0 ? 1 : 0) + (settings_.friction != 0 ? 1 : 0) +
                              (settings_.effort != 0 ? 1 : 0) + (settings_.torque ? 1 : 0) +
                              (settings_.HasLimits() ? 2 : 0);
  info->nub = 0;
}

void AxisDrive::ListRows(const Moment& moment, RowList& list) {
  const btScalar position = axis_.BeginStep();
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
            ? (static_cast<btScalar>(*settings_.target) - position) * moment.erp * moment.fps
            : static_cast<btScalar>(settings_.velocity);
    motor_ = {.row = list.count,
              .position = position,
              .sought = velocity,
              .most = most,
              .fps = moment.fps,
              .erp = moment.erp};
    list.Add({velocity, -most, most});
  }
  if (settings_.torque) {
    const btScalar impulse = static_cast<btScalar>(*settings_.torque) / moment.fps;
    list.Add({0, impulse, impulse});
  }
  if (!settings_.HasLimits()) return;
  const auto approach = [&](double limit, btScalar inside) {
    const btScalar room = static_cast<btScalar>(limit) - position;
    return (room * inside < 0 ? moment.erp : btScalar(1)) * room * moment.fps;
  };
  list.Add({approach(settings_.lower, -1), 0, SIMD_INFINITY});
  list.Add({approach(settings_.upper, 1), -SIMD_INFINITY, 0});
}

void AxisDrive::getInfo2(btConstraintInfo2* info) {
  const auto [first, second] = axis_.Shares();
  // If nothing else holds the two bodies.
  const btScalar mobility = first.Mobility() + second.Mobility();
  RowList list;
  ListRows({.rate = first.Rate() + second.Rate(),
            .mobility = mobility,
            .fps = info->fps,
            .erp = info->erp},
           list);
  for (int i = 0; i < list.count; ++i) {
    const int at = i * info->rowskip;
    Put(first.linear, info->m_J1linearAxis + at);
    Put(first.angular, info->m_J1angularAxis + at);
    Put(second.linear, info->m_J2linearAxis + at);
    Put(second.angular, info->m_J2angularAxis + at);
    info->m_constraintError[at] = list.rows[i].velocity;
    info->m_lowerLimit[at] = list.rows[i].least;
    info->m_upperLimit[at] = list.rows[i].most;
  }
}

void AxisDrive::setParam(int, btScalar, int) { CDB_CHECK(false); }
btScalar AxisDrive::getParam(int, int) const { CDB_CHECK(false); }

}  // namespace cdb::world
