// Places for objects that come into the world while it runs.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/distributions/stream.h"
#include "library/layouts/clearance.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/region.h"

namespace cdb::layouts {

/// Draws places for the objects of a group, uniform in its region, from the stream
/// `<group>.location`, until one is free of the objects that are there. Computed in double from
/// their poses, so that it depends on no detector. Not thread-safe.
class Emitter {
 public:
  /// Draws for an object in a cycle.
  static constexpr int kMostDraws = 100;

  /// `group`: index of one that spawns. Scene and objects must outlive it.
  Emitter(const plan::Scene& scene, const std::vector<ObjectState>& objects, std::size_t group);

  /// The objects of the group.
  std::size_t first() const { return first_; }
  std::size_t end() const { return end_; }

  /// Forgets the objects that were there in the last cycle.
  void Begin();
  /// An object that is there.
  void Meet(std::size_t index, const objects::Pose& pose);
  /// A place at which object `index` of the group touches none of those that were met, or nullopt
  /// if none was drawn. The object is met there.
  std::optional<Eigen::Vector3d> FindPlace(std::size_t index);

 private:
  struct Neighbour {
    Core core;
    std::size_t index;
    Eigen::Quaterniond orientation;
  };

  /// Of the small ones.
  void AddToGrid(std::size_t neighbour);
  bool IsFree(std::size_t index, const Eigen::Vector3d& place) const;
  bool Touches(std::size_t index, const Core& core, const Neighbour& other) const;

  const std::vector<ObjectState>& objects_;
  double side_;
  Region region_;
  std::size_t first_ = 0, end_ = 0;
  double largest_ = 0;  ///< radius of the ball around an object of the group, m
  distributions::Stream stream_;
  std::vector<Neighbour> small_;  ///< not larger than an object of the group
  std::vector<Neighbour> large_;
  std::optional<HashGrid> grid_;  ///< of the small ones, once all are met
};

/// Throws library::SceneError if an object that spawns does not fit into its region.
void CheckEmitters(const plan::Scene& scene, const InitialState& state);

}  // namespace cdb::layouts
