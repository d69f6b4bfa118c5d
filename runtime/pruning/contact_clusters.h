// Contact clusters: groups of objects that may meet, and where each object can be after a contact.
//
// From the earliest possible contact on, a member of a cluster may move in any way that the energy
// of the cluster permits: in free fall, the energy in the falling frame; in contact with a wall or
// a fixed object, with damping or with sleeping, the energy in the world frame, to which gravity
// adds. So each member is inside a ball that grows with time. An object that the ball reaches may
// touch the cluster from then on, and joins it; then all balls grow as fast as the new energy
// permits. Contacts are processed in order of time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "runtime/pruning/trajectory.h"

namespace cdb::pruning {

/// The cube that contains the objects.
class Room {
 public:
  Room(const plan::Scene& scene, const Horizon& horizon);

  bool Stands(int wall) const { return (standing_ >> wall & 1) != 0; }
  std::uint8_t standing() const { return standing_; }
  double half() const { return half_; }
  /// No object can get past the wall, at any distance from its centre.
  bool Holds(int wall) const { return Stands(wall) && is_endless_; }
  /// Clearance, m, between the wall and an object of radius `reach`, m, whose centre is in
  /// `places`, beyond the distance at which they touch. If 0 or less, the object may touch the
  /// wall.
  double Gap(int wall, const Box& places, double reach) const;

 private:
  std::uint8_t standing_;
  double half_;
  double rounding_;  ///< m: of the position of a wall and of distances from it
  bool is_endless_;
};

/// Not for several threads.
class ContactClusters {
 public:
  /// The arguments must outlive the object. `flights` may not contain NaN or infinity.
  ContactClusters(const plan::Scene& scene, const layouts::InitialState& state,
                  const Horizon& horizon, const Room& room, const std::vector<Trajectory>& flights);

  /// To be called for every contact in free flight, which happens `time` s after the start or
  /// later.
  void MeetObject(std::size_t object, std::size_t other, double time);
  void MeetWall(std::size_t object, int wall, double time);

  /// Computes the consequences of the contacts up to the end of the run. If it has to give up,
  /// returns the reason, and any two objects may touch. Decrements `tests_left` with its work.
  std::optional<std::string> Follow(std::uint64_t& tests_left);

  /// By object: the bits of the walls that it may touch. Valid after Follow.
  const std::vector<std::uint8_t>& walls() const { return walls_; }
  std::size_t Largest() const;

 private:
  struct Event {
    double time;
    std::uint32_t object, other;
    std::int32_t wall;  ///< below 0: with `other`
    /// Versions of both when the event was predicted; it is void if one of them has changed since.
    std::uint32_t object_version, other_version;
    bool operator>(const Event& event) const;
  };

  /// The positions that the centre of an object may have after its first possible contact: a box
  /// that moves uniformly or falls, and all points within `Radius` of it.
  struct Region {
    double since = 0;
    Box core;                 ///< at `since`
    Eigen::Vector3d drift;    ///< m/s
    Eigen::Vector3d gravity;  ///< 0 in the world
    double timestep = 0;
    double radius = 0;                     ///< m, at `since`
    double rate = 0, more = 0, limit = 0;  ///< it grows by min(rate + more t, limit)
    double error = 0;                      ///< m: rounding

    double Radius(double time) const;
    Box Core(double time) const;
    /// A box that contains the region until `time`.
    Box Hull(double time) const;
  };

  struct ContactCluster {
    std::vector<std::uint32_t> members;
    bool leans = false;      ///< a member may have touched a wall or a fixed object
    bool is_slowed = false;  ///< a member is damped, or may be put to sleep
    double mass = 0;         ///< kg
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  ///< at the start
    double energy = 0;                                   ///< J: kinetic, at the start
    double energy_in_air = 0;   ///< J: the same in the frame of the centre of mass
    double energy_of_drop = 0;  ///< J: what gravity can add before walls stop all members
    double restitution = 0;     ///< the largest
  };

  struct Ball {
    Box core;
    double radius;
  };

  ContactCluster& CrowdOf(std::size_t object) { return crowds_[crowd_of_[object]]; }
  const ContactCluster& CrowdOf(std::size_t object) const { return crowds_[crowd_of_[object]]; }
  bool IsInFlight(std::size_t object) const { return version_[object] == 0; }
  bool IsFixed(std::size_t object) const { return flights_[object].motion == Motion::kFixed; }

  double WeightedDrop(std::size_t object) const;
  double KineticEnergy(std::size_t object, const Eigen::Vector3d& frame) const;
  double Boost(const ContactCluster& crowd, std::size_t object) const;
  double SpeedInAir(const ContactCluster& crowd, std::size_t object) const;
  bool FallsFreely(const ContactCluster& crowd) const;

  std::uint32_t Join(std::size_t object);
  void Merge(std::uint32_t to, std::uint32_t from);
  Region RegionFrom(const ContactCluster& crowd, bool falls, std::size_t object, double time) const;
  bool Redirect(std::uint32_t crowd, double time);
  void ForeseeWalls(std::size_t object);
  void ForeseeMeetings(std::size_t object);
  void ForeseeMeeting(std::size_t object, std::size_t other);
  bool Spend(std::uint64_t tests);

  Ball BallOf(std::size_t object, double time) const;
  double FastestInWorld(std::size_t object) const;
  double FastestInAir(std::size_t object) const;
  double ErrorOf(std::size_t object) const;
  template <typename Gap>
  std::optional<double> FirstContact(double begin, double fastest, double near, const Gap& gap);

  const layouts::InitialState& state_;
  const Horizon& horizon_;
  const Room& room_;
  const std::vector<Trajectory>& flights_;
  const bool sleeps_, is_faithful_;
  const double erp_;

  std::vector<ContactCluster> crowds_;
  std::vector<std::uint32_t> crowd_of_;  ///< by object
  std::vector<std::uint32_t> version_;   ///< by object: 0 in free flight
  std::vector<Region> regions_;          ///< by object, of those in clusters
  std::vector<std::uint32_t> touched_;   ///< the objects in clusters
  std::vector<std::uint8_t> walls_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::uint64_t* tests_left_ = nullptr;
  bool has_given_up_ = false;

  /// The free trajectories sorted along one axis, for queries by a box.
  struct Path {
    Box box;
    std::uint32_t object;
  };
  void SortPaths();
  int path_axis_ = 0;
  double longest_path_ = 0;
  std::vector<Path> paths_;
};

}  // namespace cdb::pruning
