// The detectors of a run, made from the names in its scene.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"
#include "library/detectors/detector.h"

namespace cdb::detection {

/// A detector and its description.
struct NamedDetector {
  std::string name;
  Phases phases = {};
  std::uint64_t max_bodies = 0;  ///< walls included; 0 means no limit
  std::shared_ptr<Detector> detector;
  /// As a narrow phase it lists all contact points of a pair in each cycle, not one of them.
  bool lists_all_points = false;
  unsigned threads = 1;  ///< the number that it may use, including the caller's

  explicit operator bool() const { return detector != nullptr; }
  bool WantsPoses() const { return HasAny(phases, cdb::kNarrow | cdb::kNeedsPoses); }
};

/// The detector `name` of any kind: cdb's own, Bullet's, one of an optional part, a plug-in. It
/// gets the scene's `threads`. Throws library::SceneError if this build does not have it.
NamedDetector MakeDetector(std::string_view name, const plan::Scene& scene);

/// The detector `name` as a narrow phase. Throws library::SceneError also if it is none.
NamedDetector MakeNarrowPhase(std::string_view name, const plan::Scene& scene);

/// The detectors of a run; one detector may be both.
struct Detectors {
  NamedDetector broad;   ///< null: Bullet's, named by the scene
  NamedDetector narrow;  ///< null: Bullet's
};

/// The detectors that the scene names in `detector` and `narrow_phase`. Bullet's four broad phases
/// are used directly if the contacts are Bullet's too, and through the detector interface
/// otherwise. Throws library::SceneError if one does not exist, or lacks the phase.
Detectors MakeDetectors(const plan::Scene& scene);

/// The detector is one of Bullet's broad phases, alone or through the interface.
bool IsBullets(std::string_view detector);

/// Rethrows the current exception as a library::SceneError that names the detector, the function
/// (`FindPairs`) and the cycle (0: before the first).
[[noreturn]] void Blame(const NamedDetector& detector, std::string_view in, std::uint64_t cycle);

/// Throws library::SceneError if the number of bodies, walls included, exceeds the detector's
/// limit.
void CheckHolds(std::string_view detector, std::uint64_t max_bodies, std::size_t bodies);

}  // namespace cdb::detection
