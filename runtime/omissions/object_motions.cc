#include "runtime/omissions/object_motions.h"

#include <algorithm>

namespace cdb::omissions {

using Eigen::Vector3d;

Box Grown(const Box& box, double by) { return {box.min().array() - by, box.max().array() + by}; }

double Region::Radius(double time) const {
  const double left = time - since;
  return radius + std::min(rate * left + more * (time * time - since * since) / 2, limit * left);
}

Box Region::Core(double time) const {
  const Vector3d moved = drift * (time - since) + FallUntil(gravity, timestep, time) -
                         FallUntil(gravity, timestep, since);
  return {core.min() + moved, core.max() + moved};
}

Box Region::Hull(double time) const {
  // As a parabola in the time since the start.
  const Vector3d c0 = -drift * since - FallUntil(gravity, timestep, since);
  const Box moved = RangeOf(c0, drift + gravity * (timestep / 2), gravity / 2, since, time);
  return Grown({core.min() + moved.min(), core.max() + moved.max()}, Radius(time) + error);
}

ObjectMotions::ObjectMotions(const std::vector<Trajectory>& trajectories,
                             const Vector3d& acceleration, const Horizon& horizon)
    : trajectories_(trajectories),
      fall_(acceleration.stableNorm() * (horizon.end + horizon.timestep)),
      versions_(trajectories.size()),
      regions_(trajectories.size()) {}

void ObjectMotions::SetRegion(std::size_t object, const Region& region) {
  regions_[object] = region;
  ++versions_[object];
}

Ball ObjectMotions::BallAt(std::size_t object, double time) const {
  if (!IsInFlight(object)) {
    const Region& region = regions_[object];
    return {region.Core(time), region.Radius(time)};
  }
  const Trajectory& trajectory = trajectories_[object];
  if (trajectory.motion == Motion::kSlowed) return {trajectory.PathUntil(time), 0};
  return {Box(trajectory.PlaceAt(time)), 0};
}

double ObjectMotions::ErrorOf(std::size_t object) const {
  return IsInFlight(object) ? trajectories_[object].slack.stableNorm() : regions_[object].error;
}

double ObjectMotions::FastestInWorld(std::size_t object) const {
  if (IsFixed(object)) return 0;
  if (IsInFlight(object)) return trajectories_[object].velocity.stableNorm() + fall_;
  const Region& region = regions_[object];
  return region.limit + region.drift.stableNorm() + (region.gravity.isZero(0) ? 0 : fall_);
}

double ObjectMotions::FastestInAir(std::size_t object) const {
  if (IsInFlight(object)) {
    if (trajectories_[object].motion == Motion::kFree)
      return trajectories_[object].velocity.stableNorm();
  } else if (!regions_[object].gravity.isZero(0)) {
    return regions_[object].limit + regions_[object].drift.stableNorm();
  }
  return FastestInWorld(object) + fall_;
}

}  // namespace cdb::omissions
