#include "runtime/engine/world/pushes.h"

#include "compiler/analysis/expectation.h"
#include "library/scene_error.h"
#include "runtime/engine/world/conversions.h"

namespace cdb::world {

analysis::TimeTable ReadTable(const schema::Call& call, const plan::GroupSettings& settings,
                              const schema::Parameter& parameter) {
  try {
    return analysis::ReadTimeTable(call, analysis::UnitIn(settings, parameter),
                                   parameter.type == schema::ParameterType::kVector);
  } catch (const plan::TableError& error) {
    throw library::SceneError(error.what(), error.remedy);
  }
}

Pushes::Pushes(const plan::Scene& scene, const layouts::InitialState& state,
               const std::vector<std::unique_ptr<btRigidBody>>& objects)
    : objects_(objects) {
  for (std::size_t i = 0; i < state.objects.size(); ++i)
    if (!state.objects[i].IsFixed() && analysis::HasPush(scene.groups[state.objects[i].group]))
      pushed_.push_back(i);
  if (pushed_.empty()) return;
  pushes_.resize(state.objects.size());
  before_.resize(pushed_.size());
  for (const std::size_t i : pushed_)
    pushes_[i] = {state.objects[i].force, state.objects[i].torque};
}

Pushes::Motion Pushes::MotionOf(std::size_t object) const {
  return {ToEigen(objects_[object]->getLinearVelocity()),
          ToEigen(objects_[object]->getAngularVelocity())};
}

void Pushes::BeforeStep(Multibodies* multibodies) {
  for (std::size_t i = 0; i < pushed_.size(); ++i) {
    const std::size_t object = pushed_[i];
    before_[i] = MotionOf(object);
    const btVector3 force = ToBullet(pushes_[object].force),
                    torque = ToBullet(pushes_[object].torque);
    if (multibodies != nullptr && multibodies->IsLink(object)) {
      multibodies->Push(object, force, torque);
    } else {
      objects_[object]->applyCentralForce(force);
      objects_[object]->applyTorque(torque);
    }
  }
}

void Pushes::AfterStep(double timestep) {
  for (std::size_t i = 0; i < pushed_.size(); ++i) {
    const Motion now = MotionOf(pushed_[i]);
    const Push& push = pushes_[pushed_[i]];
    work_ += timestep / 2 *
             (push.force.dot(before_[i].velocity + now.velocity) +
              push.torque.dot(before_[i].spin + now.spin));
  }
}

}  // namespace cdb::world
