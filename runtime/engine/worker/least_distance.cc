#include "runtime/engine/worker/least_distance.h"

#include <algorithm>
#include <limits>

#include "library/exact/signed_distance.h"
#include "library/objects/distance.h"

namespace cdb::worker {

LeastDistance::LeastDistance(const world::Engine& engine, const robots::KinematicTree& tree)
    : objects_(engine.initial_state().objects) {
  std::vector<char> moves(objects_.size(), 0);
  for (const std::size_t object : tree.moved()) moves[object] = 1;
  for (std::size_t a = 0; a < objects_.size(); ++a)
    for (std::size_t b = a + 1; b < objects_.size(); ++b)
      if ((moves[a] != 0 || moves[b] != 0) && engine.MayTouch(a, b) &&
          engine.objects()[a]->checkCollideWith(engine.objects()[b].get()))
        pairs_.emplace_back(a, b);
  boxes_.resize(objects_.size());
}

double LeastDistance::Of(const std::vector<objects::Pose>& poses) {
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    boxes_[i] = objects::Bounds(objects_[i].solid, poses[i].orientation);
    boxes_[i].lower += poses[i].position;
    boxes_[i].upper += poses[i].position;
  }
  candidates_.clear();
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const objects::Box &a = boxes_[pairs_[i].first], &b = boxes_[pairs_[i].second];
    const double bound =
        (a.lower - b.upper).cwiseMax(b.lower - a.upper).cwiseMax(0).matrix().norm();
    candidates_.push_back({bound, i});
  }
  std::ranges::sort(candidates_, {}, &Candidate::bound);
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : candidates_) {
    if (candidate.bound >= least) break;
    const auto [a, b] = pairs_[candidate.pair];
    least = std::min(least,
                     objects::Distance(objects_[a].solid, poses[a], objects_[b].solid, poses[b]));
  }
  return least;
}

double LeastDistance::ExactOf(const std::vector<objects::Pose>& poses) const {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [a, b] : pairs_) {
    const exact::SignedDistance distance =
        exact::DistanceOf(objects_[a].solid, poses[a], objects_[b].solid, poses[b], least);
    if (distance.is_inside) return 0;
    if (distance.lower < least) least = std::max(0.0, std::min(least, distance.gap));
    if (least == 0) break;
  }
  return least;
}

}  // namespace cdb::worker
