// Contact clusters: groups of objects that may meet, and the possible positions of each object
// after a contact.
//
// From the earliest possible contact on, a member of a cluster may move in any way that the energy
// of the cluster permits (ClusterEnergy): each member is inside a ball that grows with time. An
// object that the ball reaches may touch the cluster from then on and joins it; all balls then grow
// as fast as the new energy permits. Contacts are processed in order of time.
//
// SI units. Errors: none. Threads: one.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/omissions/trajectory.h"

namespace cdb::omissions {

// Bounds the speed of the members of a contact cluster by its energy: in free fall, the energy in
// the falling frame; in contact with a wall or a fixed object, with damping or with sleeping, the
// energy in the world frame, to which gravity adds.
//
// SI units. Errors: none. Threads: any.

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

class ContactClusters {
 public:
  /// The arguments must outlive the object. `trajectories` must not contain NaN or infinity.
  ContactClusters(const plan::Scene& scene, const layouts::InitialState& state,
                  const Horizon& horizon, const Room& room,
                  const std::vector<Trajectory>& trajectories);

  /// Call for every contact in free flight, which happens `time` s after the start or later.
  void MeetObject(std::size_t object, std::size_t other, double time);
  void MeetWall(std::size_t object, int wall, double time);

  /// Computes the consequences of the contacts up to the end of the run. If it has to give up,
  /// returns the reason; any two objects may then touch. Decrements `tests_left` by its work.
  std::optional<std::string> Follow(std::uint64_t& tests_left);

  /// By object: the bits of the walls that it may touch. Valid after Follow.
  const std::vector<std::uint8_t>& walls() const { return walls_; }
  std::size_t Largest() const;

 private:
  struct Event {
    double time;
    std::uint32_t object, other;
    std::int32_t wall;  ///< negative: the event is with `other`
    /// Versions of both objects when the event was predicted; it is void if one of them has
    /// changed.
    std::uint32_t object_version, other_version;
    bool operator>(const Event& event) const;
  };

  const ContactCluster& ClusterOf(std::size_t object) const {
    return clusters_[cluster_of_[object]];
  }
  std::uint32_t Join(std::size_t object);
  void Merge(std::uint32_t to, std::uint32_t from);
  std::optional<std::string> Process(const Event& event);
  bool Redirect(ContactCluster& cluster, double time);

  void SortPaths();
  void ForeseeWalls(std::size_t object);
  void ForeseeMeetings(std::size_t object);
  void ForeseeMeeting(std::size_t object, std::size_t other);
  template <typename Gap>
  std::optional<double> FirstContact(double begin, double fastest, double near, const Gap& gap);
  bool Spend(std::uint64_t tests);

  const layouts::InitialState& state_;
  const Horizon& horizon_;
  const Room& room_;
  const ClusterEnergy energy_;
  ObjectMotions motions_;

  std::vector<ContactCluster> clusters_;
  std::vector<std::uint32_t> cluster_of_;  ///< by object
  std::vector<std::uint32_t> touched_;     ///< the objects in clusters
  std::vector<std::uint8_t> walls_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  SortedBoxes paths_;  ///< of the free trajectories
  std::uint64_t* tests_left_ = nullptr;
  bool has_given_up_ = false;
};

}  // namespace cdb::omissions
