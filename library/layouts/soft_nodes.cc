#include "library/layouts/soft_nodes.h"

#include "compiler/analysis/soft.h"
#include "library/objects/soft_form.h"

namespace cdb::layouts {

std::vector<Eigen::Vector3d> NodesAbout(const plan::Scene& scene, const ObjectState& object) {
  const schema::Value& type = scene.groups[object.group].settings.Get("type");
  const analysis::SoftMesh mesh =
      analysis::IsOfFile(type) ? objects::SoftMeshOf(type) : analysis::LatticeOf(type);
  const Eigen::Vector3d extent =
      object.solid.sides - Eigen::Vector3d::Constant(2 * object.numbers["margin"]);
  std::vector<Eigen::Vector3d> nodes;
  nodes.reserve(mesh.NodeCount());
  for (std::size_t node = 0; node < mesh.NodeCount(); ++node) {
    const Eigen::Vector3d place = mesh.PlaceOf(node) - Eigen::Vector3d::Constant(0.5);
    nodes.push_back(object.pose.orientation * place.cwiseProduct(extent));
  }
  return nodes;
}

}  // namespace cdb::layouts
