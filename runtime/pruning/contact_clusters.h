// Objects that may meet one another, and where each of them can get to once they have.
//
// From the earliest moment of a meeting on, a member of a crowd may move in any way that the
// crowd's energy allows: alone in the air, the energy in the frame that falls with it; with a wall,
// a fixed object, damping or sleep, the energy in the world, to which gravity adds. So each member
// is in a ball that grows. Whomever it comes to touches the crowd then and no sooner, and joins;
// from then on all grow as fast as the crowd's new energy lets them. Meetings are taken in the
// order of time.
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

/// The cube that the objects are in.
class Room {
 public:
  Room(const plan::Scene& scene, const Horizon& horizon);

  bool Stands(int wall) const { return (standing_ >> wall & 1) != 0; }
  std::uint8_t standing() const { return standing_; }
  double half() const { return half_; }
  /// Nothing that has reached the wall gets past it, however far aside it goes.
  bool Holds(int wall) const { return Stands(wall) && is_endless_; }
  /// How far beyond touching distance from the wall an object stays, m, with its centre in `places`
  /// and `reach` m from there to its outside. 0 or less: it may touch it.
  double Gap(int wall, const Box& places, double reach) const;

 private:
  std::uint8_t standing_;
  double half_;
  double rounding_;  ///< m: of a wall's place, and of a distance from it
  bool is_endless_;
};

/// Not for several threads.
class ContactClusters {
 public:
  /// What the arguments point to must outlive it. `flights` may have no NaN or infinity.
  ContactClusters(const plan::Scene& scene, const layouts::InitialState& state,
                  const Horizon& horizon, const Room& room, const std::vector<Trajectory>& flights);

  /// All meetings there are in free flight, `time` s after the start or later.
  void MeetObject(std::size_t object, std::size_t other, double time);
  void MeetWall(std::size_t object, int wall, double time);

  /// Follows what comes of the meetings, to the end. What was in its way if it had to give up: then
  /// anything may touch anything. Takes from `tests_left` for the work.
  std::optional<std::string> Follow(std::uint64_t& tests_left);

  /// By object, bits: the walls that it may touch. After Follow.
  const std::vector<std::uint8_t>& walls() const { return walls_; }
  std::size_t Largest() const;

 private:
  struct Event {
    double time;
    std::uint32_t object, other;
    std::int32_t wall;  ///< below 0: with `other`
    /// Of both when it was foreseen; it is void once one of them has changed its way.
    std::uint32_t object_version, other_version;
    bool operator>(const Event& event) const;
  };

  /// The places that the centre of an object may have, since it first may have met something: a box
  /// that moves straight on or falls, and all around it as far as `Radius`.
  struct Region {
    double since = 0;
    Box core;                 ///< at `since`
    Eigen::Vector3d drift;    ///< m/s
    Eigen::Vector3d gravity;  ///< 0 in the world
    double timestep = 0;
    double radius = 0;                     ///< m, at `since`
    double rate = 0, more = 0, limit = 0;  ///< it grows by the less of rate + more t and limit
    double error = 0;                      ///< m: rounding

    double Radius(double time) const;
    Box Core(double time) const;
    /// Holds all of it until `time`.
    Box Hull(double time) const;
  };

  struct ContactCluster {
    std::vector<std::uint32_t> members;
    bool leans = false;      ///< some may have met a wall or a fixed object
    bool is_slowed = false;  ///< some are damped, or may be put to sleep
    double mass = 0;         ///< kg
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  ///< at the start
    double energy = 0;                                   ///< J: kinetic, at the start
    double energy_in_air = 0;   ///< J: the same in the frame of the centre of mass
    double energy_of_drop = 0;  ///< J: what gravity can add until walls hold them all
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
  std::vector<Region> regions_;          ///< by object, of those in crowds
  std::vector<std::uint32_t> touched_;   ///< the objects in crowds
  std::vector<std::uint8_t> walls_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::uint64_t* tests_left_ = nullptr;
  bool has_given_up_ = false;

  /// The free paths in the order of one axis, so that those near a box are found.
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
