#include "library/layouts/nudge.h"

#include "compiler/reference.h"
#include "library/distributions/stream.h"

namespace cdb::library {

void Nudge(const compiler::Scene& scene, InitialState& state) {
  Stream stream(scene.seeds.at("nudge"));
  for (ObjectState& object : state.objects) {
    const Eigen::Vector3d direction = stream.Turn() * Eigen::Vector3d::UnitX();
    if (object.IsFixed()) continue;
    object.pose.position += compiler::kNudge * object.solid.sides.maxCoeff() * direction;
  }
}

}  // namespace cdb::library
