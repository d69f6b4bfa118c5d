#include "runtime/omissions/contact_clusters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "runtime/omissions/omissions.h"

namespace cdb::omissions {
namespace {

constexpr std::uint32_t kNoCluster = std::numeric_limits<std::uint32_t>::max();

/// A gap smaller than this, relative to the size, counts as touching. So does an approach that
/// takes more than kMaxApproaches steps.
constexpr double kNearly = 1e-3;
constexpr int kMaxApproaches = 200;
/// The cost of such a step, in tests of two boxes.
constexpr std::uint64_t kTestsOfApproach = 4;

}  // namespace

bool ContactClusters::Event::operator>(const Event& event) const {
  const auto key = [](const Event& it) { return std::tie(it.time, it.object, it.other, it.wall); };
  return key(*this) > key(event);
}

ContactClusters::ContactClusters(const plan::Scene& scene, const layouts::InitialState& state,
                                 const Horizon& horizon, const Room& room,
                                 const std::vector<Trajectory>& trajectories)
    : state_(state),
      horizon_(horizon),
      room_(room),
      energy_(scene, state, horizon, room, trajectories),
      motions_(trajectories, state.acceleration, horizon),
      cluster_of_(trajectories.size(), kNoCluster),
      walls_(trajectories.size()) {}

void ContactClusters::MeetObject(std::size_t object, std::size_t other, double time) {
  events_.push({time, static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(other), -1,
                motions_.version(object), motions_.version(other)});
}

void ContactClusters::MeetWall(std::size_t object, int wall, double time) {
  events_.push({time, static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(object), wall,
                motions_.version(object), motions_.version(object)});
}

std::size_t ContactClusters::Largest() const {
  std::size_t largest = 1;
  for (const ContactCluster& cluster : clusters_)
    largest = std::max(largest, cluster.members.size());
  return largest;
}

std::optional<std::string> ContactClusters::Follow(std::uint64_t& tests_left) {
  tests_left_ = &tests_left;
  SortPaths();
  while (!events_.empty()) {
    const Event event = events_.top();
    events_.pop();
    if (event.object_version != motions_.version(event.object) ||
        event.other_version != motions_.version(event.other))
      continue;
    if (auto why = Process(event)) return why;
  }
  return std::nullopt;
}

/// Returns the reason if the analysis has to give up.
std::optional<std::string> ContactClusters::Process(const Event& event) {
  for (const std::uint32_t i : {event.object, event.other})
    if (std::isfinite(state_.objects[i].numbers["contact_stiffness"]))
      return fmt::format("object {} has a soft contact, and may touch something", i + 1);
  if (event.wall >= 0) walls_[event.object] |= static_cast<std::uint8_t>(1 << event.wall);
  const bool is_alone = event.wall >= 0 || motions_.IsFixed(event.other);
  const bool is_known =
      is_alone && !motions_.IsInFlight(event.object) && ClusterOf(event.object).leans;
  if (is_known) return std::nullopt;
  const std::uint32_t cluster = Join(event.object);
  if (is_alone) {
    clusters_[cluster].leans = true;
  } else {
    Merge(cluster, Join(event.other));
  }
  if (!Redirect(clusters_[cluster], event.time))
    return fmt::format("object {} may get too far for the forecast", event.object + 1);
  if (has_given_up_) return "too many objects may meet to predict their contacts";
  return std::nullopt;
}

/// The cluster of the object; a new one if it has none.
std::uint32_t ContactClusters::Join(std::size_t object) {
  if (cluster_of_[object] != kNoCluster) return cluster_of_[object];
  cluster_of_[object] = static_cast<std::uint32_t>(clusters_.size());
  touched_.push_back(static_cast<std::uint32_t>(object));
  clusters_.push_back(energy_.Alone(object));
  return cluster_of_[object];
}

void ContactClusters::Merge(std::uint32_t to, std::uint32_t from) {
  if (to == from) return;
  for (const std::uint32_t i : clusters_[from].members) cluster_of_[i] = to;
  clusters_[to].Absorb(clusters_[from]);
}

/// Gives all members new regions from `time` on; false if one cannot be followed.
bool ContactClusters::Redirect(ContactCluster& cluster, double time) {
  energy_.Update(cluster);
  for (const std::uint32_t i : cluster.members) {
    const Region region = energy_.RegionOf(cluster, i, motions_.BallAt(i, time), time);
    if (!std::isfinite(region.Hull(horizon_.end).diagonal().squaredNorm())) return false;
    motions_.SetRegion(i, region);
  }
  for (const std::uint32_t i : cluster.members) {
    ForeseeWalls(i);
    ForeseeMeetings(i);
  }
  return true;
}

void ContactClusters::SortPaths() {
  std::vector<SweptBox> boxes;
  boxes.reserve(walls_.size());
  for (std::size_t i = 0; i < walls_.size(); ++i) {
    const Trajectory& trajectory = motions_.trajectory(i);
    const double grown =
        trajectory.radius + trajectory.threshold / 2 + trajectory.slack.stableNorm();
    boxes.push_back(
        {Grown(trajectory.PathUntil(horizon_.end), grown), static_cast<std::uint32_t>(i)});
  }
  paths_ = SortedBoxes(std::move(boxes));
}

void ContactClusters::ForeseeWalls(std::size_t object) {
  const Trajectory& trajectory = motions_.trajectory(object);
  const Region& region = motions_.region(object);
  const double reach = trajectory.radius + trajectory.threshold + region.error;
  for (int wall = 0; wall < kWallCount; ++wall) {
    if (!room_.Stands(wall) || (walls_[object] >> wall & 1) != 0) continue;
    if (room_.Gap(wall, region.Hull(horizon_.end), reach) > 0) continue;
    const auto time = FirstContact(region.since, motions_.FastestInWorld(object),
                                   kNearly * trajectory.radius, [&](double t) {
                                     const Ball ball = motions_.BallAt(object, t);
                                     return room_.Gap(wall, ball.core, ball.radius + reach);
                                   });
    if (time) MeetWall(object, wall, *time);
  }
}

void ContactClusters::ForeseeMeetings(std::size_t object) {
  const Trajectory& trajectory = motions_.trajectory(object);
  const Box hull = Grown(motions_.region(object).Hull(horizon_.end),
                         trajectory.radius + trajectory.threshold / 2);
  for (const SweptBox& path : paths_.Near(hull)) {
    if (!Spend(1)) return;
    if (motions_.IsInFlight(path.object) && path.box.intersects(hull))
      ForeseeMeeting(object, path.object);
  }
  for (const std::uint32_t other : touched_) {
    if (!Spend(1)) return;
    if (cluster_of_[other] != cluster_of_[object] && !motions_.IsInFlight(other))
      ForeseeMeeting(object, other);
  }
}

void ContactClusters::ForeseeMeeting(std::size_t object, std::size_t other) {
  // Another contact with a fixed object adds nothing to a cluster that leans on one.
  if (motions_.IsFixed(other) && ClusterOf(object).leans) return;
  const double touching =
      TouchingDistance(motions_.trajectory(object), motions_.trajectory(other)) +
      motions_.ErrorOf(object) + motions_.ErrorOf(other);
  const double fastest = std::min(motions_.FastestInWorld(object) + motions_.FastestInWorld(other),
                                  motions_.FastestInAir(object) + motions_.FastestInAir(other));
  const auto time =
      FirstContact(motions_.region(object).since, fastest, kNearly * touching, [&](double t) {
        const Ball a = motions_.BallAt(object, t), b = motions_.BallAt(other, t);
        return Distance(a.core, b.core) - a.radius - b.radius - touching;
      });
  if (time) MeetObject(object, other, *time);
}

/// A time from `begin` on, not later than the first at which `gap` is 0 or less, if there is one.
/// `gap` must never shrink faster than `fastest`.
template <typename Gap>
std::optional<double> ContactClusters::FirstContact(double begin, double fastest, double near,
                                                    const Gap& gap) {
  double time = begin;
  for (int i = 0; i < kMaxApproaches; ++i) {
    if (!Spend(kTestsOfApproach)) return time;
    const double left = gap(time);
    if (!(left > near)) return time;
    time += left / fastest;
    if (time > horizon_.end) return std::nullopt;
  }
  return time;
}

bool ContactClusters::Spend(std::uint64_t tests) {
  has_given_up_ = has_given_up_ || *tests_left_ < tests;
  *tests_left_ -= std::min(*tests_left_, tests);
  return !has_given_up_;
}

}  // namespace cdb::omissions
