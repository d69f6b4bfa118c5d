#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::kernels {
namespace {

/// False if a coordinate is NaN.
bool IsWithin(const Box& box, double reach) {
  return box.lower.x >= -reach && box.lower.y >= -reach && box.lower.z >= -reach &&
         box.upper.x <= reach && box.upper.y <= reach && box.upper.z <= reach && Overlap(box, box);
}

}  // namespace

void FiniteBoxes::Prepare(const Scene& scene) {
  UpdateBodies(scene);
  Build(scene, within_);
}

void FiniteBoxes::FindPairs(const Scene& scene, std::vector<Pair>& pairs) {
  if (UpdateBodies(scene)) Build(scene, within_);
  if (within_.size() > 1) ListPairs(scene, pairs);
  ListOthers(scene, pairs);
}

bool FiniteBoxes::UpdateBodies(const Scene& scene) {
  bool is_other = is_within_.size() != scene.size;
  is_within_.resize(scene.size);
  for (Id body = 0; body < scene.size; ++body) {
    const std::uint8_t is_within = IsWithin(scene.boxes[body], reach_);
    is_other |= is_within != is_within_[body];
    is_within_[body] = is_within;
  }
  if (!is_other) return false;
  within_.clear();
  others_.clear();
  for (Id body = 0; body < scene.size; ++body)
    (is_within_[body] ? within_ : others_).push_back(body);
  return true;
}

void FiniteBoxes::ListOthers(const Scene& scene, std::vector<Pair>& pairs) const {
  for (const Id other : others_) {
    const Box& box = scene.boxes[other];
    if (!Overlap(box, box)) continue;
    for (Id body = 0; body < scene.size; ++body) {
      // A pair of two others would be found twice; it is listed once.
      if (body == other || (!is_within_[body] && body < other)) continue;
      if (Overlap(box, scene.boxes[body]) && scene.MayCollide(other, body))
        pairs.push_back(Ordered(other, body));
    }
  }
}

}  // namespace cdb::kernels
