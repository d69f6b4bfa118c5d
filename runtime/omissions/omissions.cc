#include "runtime/omissions/omissions.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "dsl/text/check.h"
#include "library/scene_error.h"
#include "runtime/omissions/reachability.h"
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

}  // namespace cdb::omissions
