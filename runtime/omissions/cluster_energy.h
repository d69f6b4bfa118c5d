// Bounds the speed of the members of a contact cluster by its energy: in free fall, the energy in
// the falling frame; in contact with a wall or a fixed object, with damping or with sleeping, the
// energy in the world frame, to which gravity adds.
//
// SI units. Errors: none. Threads: any.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/omissions/object_motions.h"
#include "runtime/omissions/room.h"
#include "runtime/omissions/trajectory.h"

namespace cdb::omissions {

/// Objects that may have touched one another, directly or through others.
struct ContactCluster {
  std::vector<std::uint32_t> members;
  bool leans = false;      ///< a member may have touched a wall or a fixed object
  bool is_slowed = false;  ///< a member is damped, or may be put to sleep; or the cluster once did
                           ///< not fall freely
  double mass = 0;         ///< kg
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  ///< at the start
  double energy = 0;                                   ///< J: kinetic, at the start
  double energy_in_air = 0;   ///< J: kinetic, in the frame of the centre of mass
  double energy_of_drop = 0;  ///< J: what gravity can add before walls stop all members
  double restitution = 0;     ///< the largest

  /// Takes over the members of the other cluster, which is empty afterwards.
  void Absorb(ContactCluster& other);
};

class ClusterEnergy {
 public:
  /// The arguments must outlive the object.
  ClusterEnergy(const plan::Scene& scene, const layouts::InitialState& state,
                const Horizon& horizon, const Room& room,
                const std::vector<Trajectory>& trajectories);

  ContactCluster Alone(std::size_t object) const;
  /// Call after the members changed: updates `energy_in_air` and `is_slowed`.
  void Update(ContactCluster& cluster) const;
  /// The region of a member that is in `ball` at `time`, after a new contact of the cluster.
  Region RegionOf(const ContactCluster& cluster, std::size_t object, const Ball& ball,
                  double time) const;

 private:
  double WeightedDrop(std::size_t object) const;
  double KineticEnergy(std::size_t object, const Eigen::Vector3d& frame) const;
  double Boost(const ContactCluster& cluster, std::size_t object) const;
  double SpeedInAir(const ContactCluster& cluster, std::size_t object) const;
  bool FallsFreely(const ContactCluster& cluster) const;

  const layouts::InitialState& state_;
  const Horizon& horizon_;
  const Room& room_;
  const std::vector<Trajectory>& trajectories_;
  const bool sleeps_, is_faithful_;
  const double erp_;
};

}  // namespace cdb::omissions
