#include "library/layouts/perturbation.h"

#include "compiler/analysis/reference.h"
#include "library/distributions/stream.h"

namespace cdb::layouts {

void Perturb(const plan::Scene& scene, InitialState& state) {
  distributions::Stream stream(scene.seeds.at("nudge"));
  for (ObjectState& object : state.objects) {
    const Eigen::Vector3d direction = stream.Turn() * Eigen::Vector3d::UnitX();
    if (object.IsFixed()) continue;
    object.pose.position += analysis::kPerturbation * object.solid.sides.maxCoeff() * direction;
  }
}

}  // namespace cdb::layouts
