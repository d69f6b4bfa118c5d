// Finds energy that is lost although nothing can take it: in joints without friction, in elastic
// bounces, in rolling without resistance; and energy that is gained although nothing can give it:
// in rolling, and in rebounds. And the energy that is recorded of a scene with springs.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/engine/probes/body_states.h"
#include "runtime/engine/world/coefficients.h"
#include "runtime/protocol/recording.h"

namespace cdb::probes {

/// Of the energy that a scene has lost, contacts may have taken the work of friction and that of
/// their normal impulses: of one that turns an approach at the speed v into a separation, m v^2 (1
/// - e^2) / 2 with the coefficient of restitution e of the scene (Newton's law), where m is the
/// mass that the change of speed shows; with e = 0 all of its work, since it may take several
/// cycles. Falling asleep may have taken the kinetic energy of objects that slip, but not of those
/// that roll or fly. The work of an impulse J is J (v + v') / 2, with the velocities of its point
/// along it before and after the cycle; with the integrator's own term in the energy this is exact.
///
/// Nothing can give a scene energy but contacts that push objects out of each other, and joints
/// that pull them together. What these may give is the work that lifts all connected objects by the
/// depths of their contacts, and all by the gaps of joints, the largest since the energy was least.
/// And no impact may give more than its approach leaves: the speed of separation is at most e times
/// that of the approach. The engine must outlive it. Not thread-safe.
class EnergyAudit {
 public:
  /// `coefficients` must outlive it.
  EnergyAudit(world::Engine& engine, const world::Coefficients& coefficients);

  /// Call once before the first cycle, with its energies, J, which are those of the series of these
  /// names.
  void Begin(double kinetic, double energy);
  struct Seen {
    /// The energy that was lost and not taken, relative to the largest kinetic energy so far plus
    /// the energy of a fall by a hundredth of the objects' sizes. What joints take at once from
    /// velocities that contradict them is not lost (Links::JerkEnergy), nor is the fall through
    /// their gaps.
    double lost;
    /// The larger of two: the energy that was gained and not given, relative to the largest kinetic
    /// energy so far, without gains, plus that of a fall by a tenth of the objects' sizes; and
    /// twice that by which rebounds are too fast, relative to the energy of all approaches plus
    /// this fall.
    double gained;
  };
  /// Call after each cycle, with the states at its start and end.
  Seen After(const BodyStates& before, const BodyStates& now, double kinetic, double energy);

 private:
  double TakenBy(const btPersistentManifold& manifold, const BodyStates& before,
                 const BodyStates& now);
  double Gained(double kinetic, double energy, double sagged, double rounding);
  double LiftOfContacts();
  double PushOn(std::size_t object) const;  ///< N
  std::vector<char> Slipping(const BodyStates& states) const;
  double TakenByRounding(const BodyStates& now) const;
  double TakenBySleep(const BodyStates& before, const BodyStates& now) const;
  double KineticOf(std::size_t object, const BodyState& state) const;

  world::Engine& engine_;
  const world::Coefficients& coefficients_;
  std::vector<double> masses_;                           ///< kg, by object; 0 if it is fixed
  std::vector<Eigen::Vector3d> inertias_;                ///< principal, for 1 kg
  double weight_ = 0;                                    ///< N, of all objects
  double fall_ = 0;                                      ///< m/s: gained by a fall in a cycle
  double start_ = 0, peak_ = 0, scale_ = 0, taken_ = 0;  ///< J; scale: of a fall by the sizes
  double lowest_ = 0, given_ = 0, rounded_ = 0,
         peak_without_gain_ = 0;          ///< J; given: since the lowest energy
  double approached_ = 0, excess_ = 0;    ///< J: of impacts, and of their rebounds
  std::vector<std::uint32_t> connected_;  ///< by object: another one, or itself
};

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
