// Forward kinematics: the poses of the links of a robot in a configuration.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::robots {

/// The links of a scene, each held by the one before it or by something fixed. A position counts
/// from where the layout of the child places it, as `start` does. In double; threads: any.
class KinematicTree {
 public:
  /// `state` is that of the scene, placed. The scene has no ConfigurationFault
  /// (compiler/analysis/configurations.h) and must outlive the tree.
  KinematicTree(const plan::Scene& scene, const layouts::InitialState& state);

  /// The number of positions that make a configuration, in the order of analysis::FreedomsOf.
  std::size_t freedoms() const { return freedoms_; }
  /// Indices of the objects that configurations move; a parent precedes its children.
  const std::vector<std::size_t>& moved() const { return moved_; }
  /// True for the objects that joints hold, and those that hold them.
  bool IsLink(std::size_t object) const { return is_link_[object] != 0; }

  /// Sets the poses of the moved objects, by index; those of the others are as they were placed.
  void PosesAt(std::span<const double> positions, std::vector<objects::Pose>& poses) const;

  /// How a child is held, in the frame of its parent's origin (objects::OriginOf).
  struct Hold {
    static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
    std::size_t parent, child;  ///< objects; kNone: the world
    std::size_t freedom;        ///< kNone: it cannot move
    bool is_slider;
    Eigen::Vector3d at, axis;  ///< pivot; unit
    double start;              ///< the position at which the child is at `origin`
    objects::Pose origin;      ///< of the child
  };
  const std::vector<Hold>& holds() const { return holds_; }

 private:
  std::vector<Hold> holds_;
  std::vector<std::size_t> moved_;
  std::vector<char> is_link_;
  std::vector<objects::Pose> placed_;  ///< bodies, by object
  std::vector<objects::Solid> solids_;
  std::size_t freedoms_ = 0;
};

/// The positions of all configurations of the scene, one after the other, in the order of its
/// freedoms: drawn, read from a list, or along a path; `cycles` of them. Throws
/// library::SceneError if the list differs from the one at planning.
std::vector<double> PositionsOf(const plan::Scene& scene);

}  // namespace cdb::robots
