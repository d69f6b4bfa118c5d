// Records the series of a run with soft bodies between its cycles. Only the requested series are
// computed, and nothing here runs inside a timed cycle.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "compiler/plan/plan.h"
#include "runtime/engine/probes/energy_audit.h"
#include "runtime/engine/soft/soft_world.h"
#include "runtime/protocol/recording.h"

namespace cdb::soft {

/// J, of soft bodies and the rigid ones that move.
struct SoftEnergy {
  double kinetic = 0;
  double weight = 0;            ///< of gravity
  double weight_with_term = 0;  ///< plus the integrator's own, dt F.v / 2
  probes::SpringEnergies springs;
};
SoftEnergy EnergyOf(const SoftWorld& world);

/// kg m^2/s: the angular momentum of a rigid body about its centre of mass.
Eigen::Vector3d SpinOf(const btRigidBody& body, const layouts::ObjectState& object);

/// Of nodes and free rigid bodies.
struct SoftMomentum {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  ///< kg m/s
  double parts = 0;                               ///< kg m/s: sum of m|v|
  double mass = 0;                                ///< kg
};
SoftMomentum MomentumOf(const SoftWorld& world);

/// Largest length of a link over its rest length, minus 1.
double StretchOf(const SoftWorld& world);

struct SoftVolume {
  /// Of the tetrahedra of all blocks, over that of the start; nullopt without a block.
  std::optional<double> ratio;
  std::int32_t inverted = 0;  ///< tetrahedra that are flat or inside out
};
SoftVolume VolumeOf(const SoftWorld& world);

/// The world must outlive it. Not thread-safe.
class SoftProbes {
 public:
  SoftProbes(const plan::Scene& scene, SoftWorld& world, protocol::Recording& recording);
  /// Call before the first recorded cycle.
  void Begin();
  /// Call after each.
  void Record(std::uint64_t cycle);

 private:
  /// A rigid object or a wall.
  struct Obstacle {
    Obstacle(objects::Solid of, const btRigidBody& its_body);
    void ReadPose();

    objects::Solid solid;
    const btRigidBody* body;
    objects::Pose pose;
    Eigen::Vector3d lower, upper;  ///< of its box
    bool has_passed = false;
  };
  /// Sums over the rigid objects.
  struct RigidCounts {
    double fastest = 0;
    std::int32_t escaped = 0, removed = 0, non_finite = 0, passed = 0;
  };
  struct Depths {
    double deepest = 0;
    std::int32_t inside = 0;
  };

  void ReadNodes();
  void RecordStability(std::uint64_t cycle);
  void RecordVertices(std::uint64_t cycle);
  void RecordPoses(std::uint64_t cycle);
  RigidCounts RecordRigid();
  double MomentumError(std::uint64_t cycle);
  Depths DepthsOf(std::size_t body) const;
  bool HasPassed(const Obstacle& one, const Eigen::Vector3d& last) const;
  bool IsBeyondWall(const Eigen::Vector3d& centre, char& fell_off) const;

  SoftWorld& world_;
  protocol::Recording& recording_;
  const std::uint64_t cycles_;
  const bool all_walls_, floor_;
  const bool is_closed_;             ///< nothing but gravity acts on it from outside
  std::vector<Obstacle> obstacles_;  ///< the rigid objects, then the walls
  std::vector<std::vector<Eigen::Vector3d>> nodes_, last_nodes_;  ///< m, by soft body
  std::vector<Eigen::AlignedBox3d> sweeps_;                       ///< of both, by soft body
  std::vector<char> is_finite_;                                   ///< by soft body
  std::vector<char> fell_off_;  ///< the edge of a floor, by soft body and rigid object
  SoftMomentum first_;
  double largest_momentum_ = 0;
};

}  // namespace cdb::soft
