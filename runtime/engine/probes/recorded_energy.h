// The energy that is recorded of a scene with springs.
#pragma once

#include "runtime/protocol/recording.h"

namespace cdb::probes {

/// J, of springs.
struct SpringEnergies {
  double plain = 0;
  double with_term = 0;  ///< plus the integrator's own, dt F.v / 2
};

/// J: kinetic energy, that of springs, and `other`, as a rule with the integrator's own term, which
/// explicit springs keep (Links::SpringEnergy). They also keep it where they explode: near
/// w timestep = 2 with a hundred times as much kinetic energy, and beyond, where it can become less
/// than any bound while the objects get ever faster. So the plain energy of springs counts if it
/// has grown without a bound, or if kinetic energy and springs together are below 0, as they never
/// are below that limit.
inline double RecordedEnergy(double kinetic, double other, const SpringEnergies& springs,
                             const protocol::VerdictScales& scales) {
  constexpr double kDiverged = 1e4;
  const double plain = kinetic + other + springs.plain;
  const bool is_diverged = kinetic + springs.with_term < 0 ||
                           plain - scales.initial_energy > kDiverged * scales.energy_scale;
  return is_diverged ? plain : kinetic + other + springs.with_term;
}

}  // namespace cdb::probes
