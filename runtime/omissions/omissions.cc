#include "runtime/omissions/omissions.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "compiler/analysis/expectation.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "library/layouts/exact_layouts.h"
#include "library/scene_error.h"
#include "runtime/omissions/contact_clusters.h"
#include "runtime/omissions/trajectory.h"

namespace cdb::omissions {
namespace {

using analysis::Decision;
using analysis::PruningDecision;
using schema::Component;

/// Half of the diagonal, m, at which Bullet disables a body, as a safety margin.
constexpr double kSafeBox = analysis::kLargestBox / 2;
/// The size of Bullet's pools, and room for boxes that overlap although nothing touches.
constexpr int kBulletsPool = 4096, kFewPairs = 64;

class Settlement {
 public:
  Settlement(const plan::Scene& scene, const layouts::InitialState& state)
      : forecast_(AnalyseReachability(scene, state)),
        rests_(scene.world.On("sleeping") &&
               (!forecast_.nothing_touches || forecast_.longest_rest >= kSleepAfter)) {
    const auto standing = static_cast<std::size_t>(std::popcount(StandingWalls(scene)));
    for (std::size_t i = 0; i < state.objects.size(); ++i) {
      const bool is_fixed = state.objects[i].IsFixed();
      (is_fixed ? fixed_ : moving_) += 1;
      if (is_fixed) continue;
      all_ += standing;
      kept_ += static_cast<std::size_t>(std::popcount(forecast_.walls[i]));
    }
    pool_size_ = PoolSize();
    const auto in_pieces = std::ranges::find_if(state.objects, [](const auto& object) {
      return !object.solid.IsSurface() && object.solid.PieceCount() > 1;
    });
    if (in_pieces != state.objects.end()) in_pieces_ = in_pieces - state.objects.begin() + 1;
  }

  PruningDecision Settle(Component component) const {
    const auto decide = [&](bool leave_out, std::string why) {
      return PruningDecision{component, leave_out ? Decision::kLeftOut : Decision::kKept,
                             std::move(why)};
    };
    switch (component) {
      case Component::kWalls:
        return Walls();
      case Component::kDetection:
        if (forecast_.largest_box >= kSafeBox)
          return decide(false, fmt::format("a box grows to {:.4g} m, which detection must check",
                                           forecast_.largest_box));
        [[fallthrough]];
      case Component::kSolver:
        // Islands decide which objects sleep, and pairs, touching or not, make islands.
        if (forecast_.nothing_touches && rests_) return decide(false, Rest());
        return decide(forecast_.nothing_touches, forecast_.closest);
      case Component::kSleeping:
      case Component::kStaticBoxes:
        if (!forecast_.nothing_touches) return decide(false, forecast_.closest);
        return decide(!rests_, Rest());
      case Component::kRotation:
        return decide(forecast_.nothing_touches, forecast_.closest);
      case Component::kPools:
        if (pool_size_ >= kBulletsPool)
          return decide(false, fmt::format("more than {} pairs may exist at once", kBulletsPool));
        return decide(
            true, fmt::format("room for {} pairs at once instead of {}", pool_size_, kBulletsPool));
      case Component::kWallPairs:
        if (in_pieces_ > 0)
          return decide(false, fmt::format("object {} has several convex pieces, whose contacts "
                                           "are solved in an order that depends on all pairs",
                                           in_pieces_));
        return decide(true, "a pair without a contact has no effect in sorted order");
      default:
        CDB_CHECK(false);  // the other components are decided by the numbers alone
    }
  }

  const std::vector<std::uint8_t>& walls() const { return forecast_.walls; }
  int pool_size() const { return pool_size_; }

 private:
  std::string Rest() const {
    return fmt::format("an object is slow for at most {:.3g} s; sleep comes after {:.3g}",
                       forecast_.longest_rest, kSleepAfter);
  }

  bool LeavesWallsOut() const {
    return forecast_.largest_cluster <= kLargestCluster && kept_ < all_;
  }

  PruningDecision Walls() const {
    const auto decide = [](Decision decision, std::string why) {
      return PruningDecision{Component::kWalls, decision, std::move(why)};
    };
    if (LeavesWallsOut())
      return decide(Decision::kLeftOut, fmt::format("for {} of {} pairs of object and wall; {}",
                                                    all_ - kept_, all_, forecast_.closest));
    if (all_ == 0) return decide(Decision::kKept, "no moving object could reach one");
    if (kept_ == all_)
      return decide(Decision::kKept,
                    fmt::format("every object may reach every wall; {}", forecast_.closest));
    return decide(Decision::kKept,
                  fmt::format("{} objects may meet one another, more than {}; {}",
                              forecast_.largest_cluster, kLargestCluster, forecast_.closest));
  }

  /// The number of possible pairs. If the objects are so far apart that walls can be omitted, only
  /// a few in addition to the kept walls. Never more than Bullet's own size.
  int PoolSize() const {
    const double most = moving_ * (moving_ - 1) / 2 + moving_ * fixed_ + static_cast<double>(all_);
    double enough = kBulletsPool;
    if (forecast_.nothing_touches) enough = kFewPairs;
    if (LeavesWallsOut()) enough = kFewPairs + static_cast<double>(kept_);
    return static_cast<int>(std::min({most, enough, double{kBulletsPool}}));
  }

  const Reachability forecast_;
  const bool rests_;
  double moving_ = 0, fixed_ = 0;   ///< number of objects
  std::size_t all_ = 0, kept_ = 0;  ///< number of pairs of a moving object and a wall
  int pool_size_ = 0;
  std::ptrdiff_t in_pieces_ = 0;  ///< the first object with several convex pieces, from 1; 0: none
};

}  // namespace

std::uint8_t StandingWalls(const plan::Scene& scene) {
  const std::string_view walls = scene.world.WordOr("world.walls");
  constexpr std::uint8_t kAll = (1 << kWallCount) - 1, kFloor = 1 << 2;
  return walls == "all" ? kAll : walls == "floor" ? kFloor : 0;
}

bool Omissions::Omits(Component component) const {
  return decisions[static_cast<std::size_t>(component)].decision == Decision::kLeftOut;
}

void Omissions::Keep(Component component, std::string why) {
  decisions[static_cast<std::size_t>(component)] = {component, Decision::kKept, std::move(why)};
  if (component == Component::kWalls) walls.clear();
}

Omissions DecideOmissions(const plan::Scene& scene, const layouts::InitialState& state) {
  Omissions omissions;
  omissions.decisions = analysis::AnalysePruning(scene);
  const bool has_open =
      std::ranges::count(omissions.decisions, Decision::kOpen, &PruningDecision::decision) > 0;
  if (!has_open) return omissions;
  const Settlement settlement(scene, state);
  for (PruningDecision& part : omissions.decisions) {
    if (part.decision == Decision::kOpen) part = settlement.Settle(part.component);
    if (part.decision == Decision::kKept &&
        analysis::RequestFor(scene, part.component) == analysis::PruningRequest::kByName)
      throw library::SceneError(
          fmt::format("omit {}: this scene needs it: {}", InfoOf(part.component).name, part.why));
  }
  if (omissions.Omits(Component::kWalls)) omissions.walls = settlement.walls();
  omissions.pool_size = settlement.pool_size();
  return omissions;
}

Omissions KeepEverything(const plan::Scene& scene) {
  Omissions omissions;
  omissions.decisions = analysis::AnalysePruning(scene);
  for (PruningDecision& part : omissions.decisions)
    if (part.decision != Decision::kAbsent) part = {part.component, Decision::kKept, "omit none"};
  return omissions;
}

namespace {

using Eigen::Vector3d;
using layouts::ObjectState;

/// m: Bullet enlarges boxes by 0.02 on each side.
constexpr double kBoxGrowth = 0.1;
/// Limits of tests, per object and in all. A scene that needs more is too dense to analyse; a
/// sparse one needs a hundredth.
constexpr std::uint64_t kTestsOfOne = 64, kMinTests = 1'000'000;

/// Free objects are tested against one another in the falling frame, where their paths are
/// straight; fixed and slowed objects are tested against all in the world frame.
enum Kind : std::uint8_t { kStill, kFree, kSlow };
constexpr SweepPartners kFalling = {0, 1 << kFree, 0, 0};
constexpr SweepPartners kWorld = {1 << kFree | 1 << kSlow, 1 << kStill | 1 << kSlow,
                                  1 << kStill | 1 << kFree | 1 << kSlow, 0};

/// Moving objects that may meet, by the first contacts alone: a lower bound of the clusters,
/// because contacts only add to the possible positions of an object.
class FirstClusters {
 public:
  explicit FirstClusters(std::size_t objects) : parent_(objects), size_(objects, 1) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  void Join(std::size_t a, std::size_t b) {
    a = Root(a);
    b = Root(b);
    if (a == b) return;
    if (size_[a] < size_[b]) std::swap(a, b);
    parent_[b] = a;
    size_[a] += size_[b];
    largest_ = std::max(largest_, size_[a]);
  }
  std::size_t largest() const { return largest_; }

 private:
  std::size_t Root(std::size_t object) {
    while (parent_[object] != object) object = parent_[object] = parent_[parent_[object]];
    return object;
  }

  std::vector<std::size_t> parent_, size_;
  std::size_t largest_ = 1;
};

/// An object and a wall or another object; their names are made with the text.
struct Encounter {
  double rank = std::numeric_limits<double>::infinity();  ///< s until they meet, or m between them
  std::size_t object = 0, other = 0;
  int wall = -1;

  bool HasHappened() const { return std::isfinite(rank); }
  void TakeIfLess(const Encounter& encounter) {
    if (encounter.rank < rank) *this = encounter;
  }
};

std::string Names(const Encounter& encounter) {
  return fmt::format("objects {} and {}", std::min(encounter.object, encounter.other) + 1,
                     std::max(encounter.object, encounter.other) + 1);
}

std::string MeetingText(const Encounter& meeting) {
  if (meeting.wall >= 0)
    return fmt::format("object {} may touch the wall {} at {:.4g} s", meeting.object + 1,
                       kWallNames[meeting.wall], meeting.rank);
  return fmt::format("{} may touch at {:.4g} s", Names(meeting), meeting.rank);
}

std::string EscapeText(const Encounter& escape) {
  if (escape.wall >= 0)
    return fmt::format("object {} stays {:.4g} m from the wall {}", escape.object + 1, escape.rank,
                       kWallNames[escape.wall]);
  if (escape.HasHappened())
    return fmt::format("{} stay {:.4g} m apart", Names(escape), escape.rank);
  return "there are no walls, and no two objects come close to one another";
}

/// The reason why the objects' motion cannot be known in advance, if there is one.
std::optional<std::string> WhatChanges(const plan::Scene& scene) {
  if (schema::AsCall(scene.world.Get("acceleration")) != nullptr)
    return "the acceleration changes during the run";
  for (const plan::Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0) continue;
    for (const auto velocity :
         {schema::GroupParameter("linear_velocity"), schema::GroupParameter("angular_velocity")})
      if (schema::AsCall(group.settings.Get(velocity)) != nullptr)
        return fmt::format("the {} of {} is changed during the run", velocity.name(), group.name);
    if (analysis::HasKinematic(group))
      return fmt::format("{} are kinematic and push other objects", group.name);
    if (analysis::HasPush(group)) return fmt::format("a force or a torque acts on {}", group.name);
    if (layouts::IsPile(group)) return fmt::format("{} settle before the first cycle", group.name);
    if (group.settings.On("overlap")) return fmt::format("{} may overlap initially", group.name);
  }
  if (const std::string pulled = scene.PulledGroup(); !pulled.empty())
    return fmt::format("{} are linked and pull on one another", pulled);
  return std::nullopt;
}

class Forecaster {
 public:
  Forecaster(const plan::Scene& scene, const layouts::InitialState& state)
      : what_changes_(WhatChanges(scene)),
        state_(state),
        horizon_(HorizonOf(scene)),
        room_(scene, horizon_),
        first_clusters_(state.objects.size()),
        tests_left_(kTestsOfOne * state.objects.size() + kMinTests) {
    trajectories_.reserve(state.objects.size());
    for (const ObjectState& object : state.objects)
      trajectories_.push_back(TrajectoryOf(object, state.acceleration, scene, horizon_));
    clusters_.emplace(scene, state, horizon_, room_, trajectories_);
  }

  Reachability Make() {
    forecast_.walls.assign(trajectories_.size(), 0);
    if (std::ranges::all_of(state_.objects, &ObjectState::IsFixed)) {
      forecast_.nothing_touches = true;
      forecast_.closest = "no object moves";
      return std::move(forecast_);
    }
    for (std::size_t i = 0; i < trajectories_.size(); ++i) {
      if (trajectories_[i].motion == Motion::kFixed) continue;
      const double diagonal = 2 * std::sqrt(3.0) * trajectories_[i].radius;
      forecast_.largest_box = std::max(
          forecast_.largest_box,
          diagonal + trajectories_[i].FastestUntil(horizon_.end) * horizon_.timestep + kBoxGrowth);
      forecast_.longest_rest = std::max(
          forecast_.longest_rest, LongestRest(state_.objects[i], state_.acceleration, horizon_));
    }
    if (const auto why = Follow()) GiveUp(*why);
    return std::move(forecast_);
  }

 private:
  /// The reason why the search has no answer, if there is one.
  std::optional<std::string> Follow() {
    if (what_changes_) return what_changes_;
    for (std::size_t i = 0; i < trajectories_.size(); ++i) {
      if (trajectories_[i].motion != Motion::kFixed && state_.objects[i].numbers.On("ccd"))
        return fmt::format("object {} has ccd, which finds contacts along its path", i + 1);
      if (!IsFinite(i)) return fmt::format("object {} gets too far for the forecast", i + 1);
    }
    // Before the walls, because this detects dense scenes.
    const bool are_few = MeetObjects(kFalling) && MeetObjects(kWorld);
    if (first_clusters_.largest() > kLargestCluster)
      return "too many objects may meet to predict their contacts";
    if (!are_few) return "too many objects come close to one another to predict their contacts";
    const Encounter meeting = std::exchange(meeting_, {}), escape = std::exchange(escape_, {});
    for (std::size_t i = 0; i < trajectories_.size(); ++i)
      if (trajectories_[i].motion != Motion::kFixed) MeetWalls(i);
    meeting_.TakeIfLess(meeting);
    escape_.TakeIfLess(escape);
    forecast_.nothing_touches = !meeting_.HasHappened();
    if (forecast_.nothing_touches) {
      forecast_.closest = EscapeText(escape_);
      return std::nullopt;
    }
    if (auto why = clusters_->Follow(tests_left_)) return why;
    forecast_.walls = clusters_->walls();
    forecast_.largest_cluster = clusters_->Largest();
    forecast_.closest = MeetingText(meeting_);
    return std::nullopt;
  }

  bool IsFinite(std::size_t object) const {
    const Trajectory& trajectory = trajectories_[object];
    const Box path = trajectory.PathUntil(horizon_.end);
    const Box falling = trajectory.FallingPathUntil(horizon_.end, state_.acceleration);
    // Squares of distances must not overflow either.
    const double squares = path.min().squaredNorm() + path.max().squaredNorm() +
                           falling.min().squaredNorm() + falling.max().squaredNorm() +
                           trajectory.slack.squaredNorm() +
                           std::pow(trajectory.FastestUntil(horizon_.end), 2) +
                           std::pow(trajectory.radius + trajectory.threshold, 2);
    return std::isfinite(squares) && squares < kLargestSquare;
  }

  void GiveUp(const std::string& why) {
    forecast_.nothing_touches = false;
    forecast_.largest_cluster = 0;
    for (std::size_t i = 0; i < trajectories_.size(); ++i) {
      if (trajectories_[i].motion == Motion::kFixed) continue;
      forecast_.walls[i] = room_.standing();
      ++forecast_.largest_cluster;
    }
    forecast_.closest =
        meeting_.HasHappened() ? fmt::format("{}; {}", MeetingText(meeting_), why) : why;
  }

  void MeetWalls(std::size_t object) {
    const Trajectory& trajectory = trajectories_[object];
    const Box path = trajectory.PathUntil(horizon_.end);
    for (int wall = 0; wall < kWallCount; ++wall) {
      if (!room_.Stands(wall)) continue;
      const int axis = wall / 2;
      const double reach = trajectory.extent[axis] + trajectory.threshold + trajectory.slack[axis];
      const double gap = room_.Gap(wall, path, reach);
      if (gap > 0) {
        escape_.TakeIfLess({gap + trajectory.threshold, object, object, wall});
        continue;
      }
      const double time = FirstTime(horizon_.end, [&](double t) {
        return !(room_.Gap(wall, trajectory.PathUntil(t), reach) > 0);
      });
      meeting_.TakeIfLess({time, object, object, wall});
      clusters_->MeetWall(object, wall, time);
    }
  }

  /// False if there are too many.
  bool MeetObjects(const SweepPartners& partners) {
    std::vector<SweptBox> boxes;
    boxes.reserve(trajectories_.size());
    for (std::size_t i = 0; i < trajectories_.size(); ++i) {
      const Trajectory& trajectory = trajectories_[i];
      const Kind kind = trajectory.motion == Motion::kFixed  ? kStill
                        : trajectory.motion == Motion::kFree ? kFree
                                                             : kSlow;
      if (partners[kind] == 0) continue;
      const Box path = &partners == &kFalling
                           ? trajectory.FallingPathUntil(horizon_.end, state_.acceleration)
                           : trajectory.PathUntil(horizon_.end);
      // Half the sum of the thresholds is at least the smaller one.
      const Vector3d grown =
          trajectory.extent + trajectory.slack + Vector3d::Constant(trajectory.threshold / 2);
      boxes.push_back(
          {{path.min() - grown, path.max() + grown}, static_cast<std::uint32_t>(i), kind});
    }
    return Sweep(std::move(boxes), partners, tests_left_, [&](std::uint32_t a, std::uint32_t b) {
      MeetPair(a, b);
      if (first_clusters_.largest() > kLargestCluster) tests_left_ = 0;
    });
  }

  void MeetPair(std::size_t a, std::size_t b) {
    if (trajectories_[a].motion == Motion::kFixed) std::swap(a, b);
    const bool is_slowed =
        trajectories_[a].motion == Motion::kSlowed || trajectories_[b].motion == Motion::kSlowed;
    const Approach approach = is_slowed
                                  ? BoxApproachOf(trajectories_[a], trajectories_[b], horizon_.end)
                                  : ApproachOf(trajectories_[a], trajectories_[b], horizon_.end);
    if (!approach.meets) {
      escape_.TakeIfLess(
          {approach.gap + std::min(trajectories_[a].threshold, trajectories_[b].threshold), a, b});
      return;
    }
    meeting_.TakeIfLess({approach.time, a, b});
    if (trajectories_[b].motion != Motion::kFixed) first_clusters_.Join(a, b);
    clusters_->MeetObject(a, b, approach.time);
  }

  /// m^2: above it, products of squares overflow.
  static constexpr double kLargestSquare = 1e150;

  const std::optional<std::string> what_changes_;
  const layouts::InitialState& state_;
  const Horizon horizon_;
  const Room room_;
  std::vector<Trajectory> trajectories_;
  std::optional<ContactClusters> clusters_;
  FirstClusters first_clusters_;
  std::uint64_t tests_left_;
  Encounter meeting_, escape_;
  Reachability forecast_;
};

}  // namespace

Reachability AnalyseReachability(const plan::Scene& scene, const layouts::InitialState& state) {
  return Forecaster(scene, state).Make();
}

}  // namespace cdb::omissions
