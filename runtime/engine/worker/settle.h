// Settles piles: objects that drop from above and come to rest before the first cycle.
//
// Piles are settled in double precision with a fixed detector, whatever those of the run, so that
// every run of a sweep begins with the same pile.
#pragma once

#include <cstdint>
#include <functional>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/protocol/recording.h"

namespace cdb::worker {

/// Objects settle slightly enlarged, so that they do not overlap at their true size: the first
/// factor, and those tried if it was not enough.
inline constexpr double kSettleGrowth[] = {1.02, 1.04, 1.08};
/// The same when they settle again, almost without gaps, from their positions in the pile.
inline constexpr double kCloseGrowth[] = {1.002, 1.005};
/// Units of time in which objects at rest have to come clear of one another, for each factor.
inline constexpr int kSettleClearingTime = 40, kCloseClearingTime = 10;

struct SettlingProgress {
  protocol::SettlingPhase phase = protocol::SettlingPhase::kNone;
  std::uint32_t at_rest = 0, objects = 0;  ///< of the piles
};
/// Called while piles settle, or while another process settles the same piles.
using SettlingListener = std::function<void(const SettlingProgress&)>;

/// Moves every object of a pile from the pose in which it is dropped to the one in which it comes
/// to rest; velocities stay as they were drawn. A sideways push and a spin, drawn from the stream
/// `<group>.location`, keep equal objects from standing in columns. Other objects stand still
/// meanwhile. The pile comes to rest under the scene's acceleration, which must point downwards,
/// and friction, with damping and without bounces (come_to_rest.h).
///
/// With gaps of 2 % between its objects, a pile would collapse in the first second of a run (400
/// cubes: a quarter of them moved by more than a twentieth of their size). It therefore settles a
/// second time with gaps of 0.2 % (4 of 400). If overlaps remain then, as in some piles of thin
/// plates, it keeps the gaps of 2 %.
///
/// In the single-precision build, the double-precision worker beside this program does it. Results
/// are taken from the cache if present (library/content_cache.h); of several processes that need
/// the same piles at once, one settles them. Throws library::SceneError if there is no floor or no
/// gravity, if the objects do not come to rest, or if they would overlap; std::system_error if the
/// other worker cannot be started.
void SettlePiles(const plan::Scene& scene, layouts::InitialState& state,
                 const SettlingListener& listener = {});

/// The side of the other worker, which is started with kSettleOption: settles `run` and writes the
/// poses, or an error message, to `fd`. Throws std::system_error if that fails.
inline constexpr const char* kSettleOption = "--settle";
void SettleForAnother(const plan::Run& run, int fd);

}  // namespace cdb::worker
