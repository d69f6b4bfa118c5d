#include "runtime/engine/world/schedules.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "compiler/schema/parametrised_words.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::world {
namespace {

using Eigen::Vector3d;
using schema::ArgumentOf;
using schema::GroupParameter;
using schema::WorldParameter;

bool IsDueAt(const schema::Call& call, std::uint64_t step) {
  return call.name != "every" ||
         step % std::get<schema::Number>(ArgumentOf(call, "cycles")).AsCount() == 0;
}

}  // namespace

Schedules::Schedules(const plan::Scene& scene, Engine& engine) : scene_(scene), engine_(engine) {
  Add(Target::kAcceleration, nullptr, *WorldParameter("acceleration"), 0, 1);
  std::size_t first = 0;
  for (const plan::Group& group : scene.groups) {
    const std::size_t end = first + group.settings.Count("quantity");
    Add(Target::kLinearVelocity, &group, *GroupParameter("linear_velocity"), first, end);
    Add(Target::kAngularVelocity, &group, *GroupParameter("angular_velocity"), first, end);
    first = end;
  }
}

void Schedules::Add(Target target, const plan::Group* group, const schema::Parameter& parameter,
                    std::size_t first, std::size_t end) {
  const schema::Call* call = schema::AsCall(group != nullptr ? group->settings.ValueOf(parameter)
                                                             : scene_.world.ValueOf(parameter));
  if (call == nullptr) return;
  Row row{target, call, nullptr, first, end};
  if (call->name == "every") {
    row.draw = std::make_unique<distributions::Draw>(scene_, group, parameter);
    // The initial state already has the first values.
    for (std::size_t i = first; i < end; ++i) row.draw->Vector();
  }
  rows_.push_back(std::move(row));
}

Vector3d Schedules::ValueAt(Row& row, std::uint64_t step) const {
  if (row.draw != nullptr) return row.draw->Vector();
  const auto& vector = std::get<Vector3d>(ArgumentOf(*row.call, "vector"));
  const auto& about = std::get<Vector3d>(ArgumentOf(*row.call, "about"));
  const double turns = static_cast<double>(step) * scene_.world.Real("timestep") /
                       std::get<schema::Number>(ArgumentOf(*row.call, "period")).AsReal();
  const double angle = 2 * std::numbers::pi * (turns - std::floor(turns));
  return Eigen::AngleAxisd(angle, about.stableNormalized()) * vector;
}

void Schedules::Apply(Row& row, std::uint64_t step) {
  if (step == 0 || !IsDueAt(*row.call, step)) return;
  if (row.target == Target::kAcceleration) {
    engine_.SetAcceleration(ValueAt(row, step));
    return;
  }
  for (std::size_t i = row.first; i < row.end; ++i) {
    const Vector3d value = ValueAt(row, step);
    btRigidBody& body = *engine_.objects()[i];
    if (body.isStaticOrKinematicObject()) continue;
    body.activate(true);
    if (row.target == Target::kLinearVelocity) {
      body.setLinearVelocity(ToBullet(value));
    } else {
      body.setAngularVelocity(ToBullet(value));
    }
  }
}

}  // namespace cdb::world
