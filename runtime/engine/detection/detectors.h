// The detectors of a run, made from the names in its scene.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "compiler/plan/plan.h"
#include "library/detectors/detector.h"

namespace cdb::detection {

/// A detector, and what it said of itself.
struct NamedDetector {
  std::string name;
  Phases phases = {};
  std::uint64_t max_bodies = 0;  ///< walls included; 0 means no limit
  std::shared_ptr<Detector> detector;

  explicit operator bool() const { return detector != nullptr; }
  bool WantsPoses() const { return HasAny(phases, cdb::kNarrow | cdb::kNeedsPoses); }
};

/// The detector `name` of any kind: cdb's own, Bullet's, one of an optional part, a plug-in. It
/// gets the scene's `threads`. Throws library::SceneError where this cdb has not got it.
NamedDetector MakeDetector(std::string_view name, const plan::Scene& scene);

/// None, one that finds pairs, or also one that finds contacts, which may be the same.
struct Detectors {
  NamedDetector broad;   ///< null: Bullet's, by the name that the scene has
  NamedDetector narrow;  ///< null: Bullet's
};

/// Those that the scene names in `detector` and `narrow_phase`. Bullet's four are Bullet's own as
/// long as the contacts are, and stand behind the interface as all others do where they are not.
/// Throws library::SceneError where one is not there, or lists no pairs or no contacts.
Detectors MakeDetectors(const plan::Scene& scene);

/// Throws the exception that is being handled as a library::SceneError, which says whose fault it
/// is: the detector's, in what (`FindPairs`), in which cycle (0: before the first).
[[noreturn]] void Blame(const NamedDetector& detector, std::string_view in, std::uint64_t cycle);

/// Throws library::SceneError where the detector does not hold so many bodies, walls included.
void CheckHolds(std::string_view detector, std::uint64_t max_bodies, std::size_t bodies);

}  // namespace cdb::detection
