// Records the series of a run with soft bodies between its cycles. Only the requested series are
// computed, and nothing here runs inside a timed cycle.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/engine/probes/recorded_energy.h"
#include "runtime/engine/soft/soft_world.h"
#include "runtime/protocol/recording.h"

namespace cdb::soft {

/// J.
struct SoftEnergy {
  double kinetic = 0;
  double weight = 0;            ///< of gravity
  double weight_with_term = 0;  ///< plus the integrator's own, dt F.v / 2
  probes::SpringEnergies springs;
};
SoftEnergy EnergyOf(const SoftWorld& world);

/// Largest length of a link over its rest length, minus 1.
double StretchOf(const SoftWorld& world);

/// The world must outlive it. Not thread-safe.
class SoftProbes {
 public:
  SoftProbes(const plan::Scene& scene, SoftWorld& world, protocol::Recording& recording);
  /// Call before the first recorded cycle.
  void Begin();
  /// Call after each.
  void Record(std::uint64_t cycle);

 private:
  /// A fixed object or a wall.
  struct Obstacle {
    objects::Solid solid;
    objects::Pose pose;
    Eigen::Vector3d lower, upper;  ///< of its box
  };
  struct Depths {
    double deepest = 0;
    std::int32_t inside = 0;
  };

  void ReadNodes();
  void RecordStability(std::uint64_t cycle);
  void RecordVertices(std::uint64_t cycle);
  Depths DepthsOf(std::size_t body) const;
  bool IsBeyondWall(std::size_t body, const Eigen::Vector3d& centre);

  SoftWorld& world_;
  protocol::Recording& recording_;
  const std::uint64_t cycles_;
  const bool all_walls_, floor_;
  std::vector<Obstacle> obstacles_;
  std::vector<std::vector<Eigen::Vector3d>> nodes_;  ///< m, by body
  std::vector<char> is_finite_;                      ///< by body
  std::vector<char> fell_off_;                       ///< the edge of a floor, by body
};

}  // namespace cdb::soft
