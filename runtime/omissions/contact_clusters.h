// Contact clusters: groups of objects that may meet, and the possible positions of each object
// after a contact.
//
// From the earliest possible contact on, a member of a cluster may move in any way that the energy
// of the cluster permits (cluster_energy.h): each member is inside a ball that grows with time. An
// object that the ball reaches may touch the cluster from then on and joins it; all balls then grow
// as fast as the new energy permits. Contacts are processed in order of time.
//
// SI units. Errors: none. Threads: one.
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
#include "runtime/omissions/cluster_energy.h"
#include "runtime/omissions/object_motions.h"
#include "runtime/omissions/room.h"
#include "runtime/omissions/swept_boxes.h"
#include "runtime/omissions/trajectory.h"

namespace cdb::omissions {

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
