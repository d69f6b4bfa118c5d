// The omissions of a run, decided from its initial state. Independent of the physics engine, so
// that the worker and `cdb plan --why` make the same decisions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/analysis/pruning.h"
#include "compiler/analysis/reference.h"
#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::omissions {

using analysis::kWallCount;
using analysis::kWallThickness;
/// Bits of the walls, in the order in which the engine adds them.
inline constexpr const char* kWallNames[kWallCount] = {"-x", "+x", "-y", "+y", "-z", "+z"};
/// The bits of the walls that are present in `scene`.
std::uint8_t StandingWalls(const plan::Scene& scene);

struct Omissions {
  std::vector<analysis::PruningDecision> decisions;  ///< one for each component; none is undecided
  /// By object: the bits of the walls that it keeps. If empty, every object keeps all walls.
  std::vector<std::uint8_t> walls;
  /// If the pools are omitted: the number of pairs that they hold; further ones come from the heap.
  int pool_size = 0;

  bool Omits(schema::Component component) const;
  /// Keeps the component after all: the run showed that it is needed, or must match another run.
  void Keep(schema::Component component, std::string why);
};

/// Throws library::SceneError if `omit` names a component that the scene needs.
Omissions DecideOmissions(const plan::Scene& scene, const layouts::InitialState& state);

/// Keeps every component, as `omit none` does, regardless of the scene.
Omissions KeepEverything(const plan::Scene& scene);

// Reachability analysis: the walls and objects that each object may touch during a run, proven
// before the first cycle. Independent of the physics engine. For the properties of Bullet 3.24 that
// it relies on, see trajectory.h and contact_clusters.h.
//
// Without contacts, a body in Bullet moves along x0 + (v0 + g dt/2) t + g t^2/2 up to rounding, so
// that two undamped bodies move along a straight line in each other's frame. Bodies that may meet
// form a contact cluster. From the earliest possible contact on, each member may be anywhere that
// the total energy of the cluster permits, and every body that it may meet there joins the cluster.
//
// `nothing_touches` is proven without assumptions, because then nothing ever leaves free flight.
// The consequences of contacts rest on the assumption that Bullet adds no more energy than
// ClusterEnergy allows for; runs that rely on it need an omission guard.

/// If more objects than these may meet one another, the analysis gives up: contacts that share an
/// object are likely, and a run without its walls would soon have to be restarted with all of them.
inline constexpr std::size_t kLargestCluster = 64;

struct Reachability {
  /// By object: the bits of the walls (omissions.h) that it may touch. 0 for fixed objects.
  std::vector<std::uint8_t> walls;
  /// No two objects, and no object and wall, come within touching distance during the run.
  bool nothing_touches = false;
  /// If nothing touches: the smallest clearance from walls and between objects that were tested as
  /// a pair. Otherwise: the first possible contact; if the analysis gave up, one that it found
  /// before, and the reason:
  /// `object 17 stays 42.1 m from the wall -y`, `objects 3 and 9 may touch at 1.25 s`. Objects
  /// count from 1, as in every message.
  std::string closest;
  /// Number of moving objects in the largest cluster; 1 if none may meet another. All of them if
  /// the analysis gave up: too many may meet, one with a soft contact may touch something, one has
  /// `ccd`, or numbers overflow.
  std::size_t largest_cluster = 1;
  /// m: the largest diagonal of the box of a moving object in any cycle, including its displacement
  /// in one cycle, if nothing touches. Bullet deactivates objects beyond kLargestBox.
  double largest_box = 0;
  /// s: an upper bound of the longest uninterrupted time that any moving object is below Bullet's
  /// sleeping thresholds, if nothing touches. Bullet puts objects to sleep after 2 s; the analysis
  /// accounts for that if `sleeping` is on.
  double longest_rest = 0;
};

/// The run is `warmup` plus `cycles`. Accounts for rounding in the scene's `precision`. Does not
/// throw: objects that it cannot analyse may touch everything. Deterministic. Any thread. About 5
/// ms for 1000 objects, 0.2 s for 100000; gives up on a dense scene much sooner.
Reachability AnalyseReachability(const plan::Scene& scene, const layouts::InitialState& state);

}  // namespace cdb::omissions
