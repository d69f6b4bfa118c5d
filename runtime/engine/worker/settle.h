// Settles piles: objects that drop from above and come to rest before the first cycle.
//
// They drop in double precision with a fixed detector, whatever those of the run, so that all runs
// of a sweep begin with nearly the same pile. They then come to rest as the run would move them.
#pragma once

#include <cstdint>
#include <functional>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/protocol/recording.h"

namespace cdb::worker {

/// Rounds of WatchUnrest after which settling fails: at most kMostRounds, or kMostSteps steps, but
/// no fewer than kLeastRounds.
inline constexpr int kLeastRounds = 10, kMostRounds = 100, kMostSteps = 20000;

struct SettlingProgress {
  protocol::SettlingPhase phase = protocol::SettlingPhase::kNone;
  std::uint32_t at_rest = 0, objects = 0;  ///< of the piles
};
/// Called while piles settle, or while another process settles the same piles.
using SettlingListener = std::function<void(const SettlingProgress&)>;

/// Moves every object of a pile from the pose in which it is dropped to the one in which it comes
/// to rest; velocities stay as they were drawn. A sideways push and a spin, drawn from the stream
/// `<group>.location`, keep equal objects from standing in columns. Other objects stand still
/// meanwhile. The objects fall under the scene's acceleration, which must point downwards, with
/// damping and without bounces (come_to_rest.h).
///
/// They come to rest at their true size in the run's own engine (yaml::RestScene), with Bullet's
/// narrow phase. Each round begins without velocities and without contacts from before, as the run
/// will; if something moves, it then calms down, with damping. The poses at the start of the first
/// round, after one, in which nothing moves are those of the pile; from the fifth round on, less
/// than 1 % of the objects may move. If the scene has `expect anything`, those after the last round
/// suffice.
///
/// Another process does so, so that the heap and the peak memory of this one are the same whether
/// the result was in the cache or not: the worker beside this program that has the precision of the
/// rest, which asks that of double precision to let them drop. Results are taken from the cache if
/// present (library/content_cache.h); of several processes that need the same piles at once, one
/// settles them. Throws library::SceneError if there is no floor or no gravity, or if the objects
/// do not come to rest; std::system_error if the other process cannot be started.
void SettlePiles(const plan::Scene& scene, layouts::InitialState& state,
                 const SettlingListener& listener = {});

/// The side of the other worker, which is started with kSettleOption: writes the poses after the
/// drop or, if piles come to rest in its precision, those of the piles, or an error message, to
/// `fd`. Throws std::system_error if that fails.
inline constexpr const char* kSettleOption = "--settle";
void SettleForAnother(const plan::Run& run, int fd);

}  // namespace cdb::worker
