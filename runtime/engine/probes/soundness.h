// The checks for unsound states that need the state before and after a cycle.
#pragma once

#include <optional>

#include "compiler/plan/plan.h"
#include "runtime/engine/probes/energy_audit.h"
#include "runtime/engine/probes/pass_watch.h"
#include "runtime/engine/probes/press_watch.h"
#include "runtime/engine/probes/sleep_watch.h"

namespace cdb::probes {

/// The engine must outlive it. Not thread-safe.
class Soundness {
 public:
  /// `least_sides`: m, by body, infinite for walls; must outlive it.
  Soundness(const plan::Scene& scene, world::Engine& engine, std::span<const double> least_sides);

  /// Call once before the first cycle, with its energies, J.
  void Begin(double kinetic, double energy);

  struct Seen {
    std::int32_t passed, pressed, inverted, unheld;
    double lost_energy;  ///< NaN if the scene has other ways to lose energy
  };
  /// Call after each cycle, with the energies at its end, J.
  Seen After(double kinetic, double energy);

 private:
  world::Engine& engine_;
  BodyStates before_, now_;
  PassWatch passes_;
  PressWatch presses_;
  SleepWatch sleepers_;
  std::optional<EnergyAudit> audit_;
};

}  // namespace cdb::probes
