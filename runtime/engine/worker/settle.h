// Settles piles: objects that drop from above and come to rest before the first cycle.
//
// Piles are settled in double precision with a fixed detector, whatever those of the run, so that
// every run of a sweep begins with the same pile.
#pragma once

#include <cstdint>
#include <functional>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/measure/settling.h"

namespace cdb::worker {

/// A little larger than they are, so that the objects do not overlap when they are themselves
/// again: the first factor, and those tried when it was not enough.
inline constexpr double kSettleGrowth[] = {1.02, 1.04, 1.08};

struct SettlingProgress {
  measure::SettlingPhase phase = measure::SettlingPhase::kNone;
  std::uint32_t at_rest = 0, objects = 0;  ///< of the piles
};
/// Called while it settles, or waits for another process that settles the same piles.
using SettlingListener = std::function<void(const SettlingProgress&)>;

/// Gives every object of a pile the pose in which it comes to rest, from that in which it was
/// dropped; velocities stay as they were drawn. A push to the side and a spin, drawn from the
/// stream `<group>.location`, keep equal objects from standing in columns. Other objects stand
/// still the while. The pile comes to rest under the scene's acceleration, which must point
/// downwards, friction and margins, with damping and without bounces (come_to_rest.h).
///
/// In the single-precision build, the double-precision worker beside this program does it. What was
/// settled before is taken from the cache (library/content_cache.h); of several processes that need
/// the same piles at once, one settles them.
/// Throws library::SceneError where there is no floor, no gravity, where nothing comes to rest, or
/// the objects would overlap; std::system_error where the other worker cannot be started.
void SettlePiles(const plan::Scene& scene, layouts::InitialState& state,
                 const SettlingListener& listener = {});

/// The other end of it, for a worker that is given kSettleOption: `run` is settled and the poses,
/// or why there are none, are written to `fd`. Throws std::system_error where that cannot be.
inline constexpr const char* kSettleOption = "--settle";
void SettleForAnother(const plan::Run& run, int fd);

}  // namespace cdb::worker
