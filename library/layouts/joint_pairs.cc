#include "library/layouts/joint_pairs.h"

#include <algorithm>
#include <string_view>

namespace cdb::layouts {
namespace {

/// The objects at one side of a joint.
struct Side {
  std::size_t first = JointPair::kWorld, count = 1;

  Side(const plan::Scene& scene, std::string_view name) {
    std::size_t next = 0;
    for (const plan::Group& group : scene.groups) {
      const std::size_t quantity = group.settings.Count("quantity");
      if (group.name == name) {
        first = next;
        count = quantity;
      }
      next += quantity;
    }
  }
  std::size_t At(std::size_t i) const {
    return first == JointPair::kWorld || count == 1 ? first : first + i;
  }
};

}  // namespace

std::vector<JointPair> JointPairsOf(const plan::Scene& scene) {
  std::vector<JointPair> pairs;
  for (const plan::Joint& joint : scene.joints) {
    if (!scene.HoldsObjects(joint)) continue;
    const Side parent(scene, joint.settings.WordOr("joints.parent")),
        child(scene, joint.settings.WordOr("joints.child"));
    for (std::size_t i = 0; i < std::max(parent.count, child.count); ++i)
      pairs.push_back({&joint, parent.At(i), child.At(i)});
  }
  return pairs;
}

}  // namespace cdb::layouts
