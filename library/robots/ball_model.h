// A robot whose links are balls, among fixed boxes, balls, capsules and cylinders: what the check
// of configurations by lanes (library/robots/lanes.h) takes.
//
// In m and double, in the frames of the links' origins (objects::OriginOf). Threads: any, once
// made.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"
#include "library/robots/kinematic_tree.h"

namespace cdb::robots {

struct Ball {
  Eigen::Vector3d centre;
  double radius;
};

/// A fixed solid, or a part of one: a box with rounded edges, which is a ball without sides, and a
/// capsule with one; or a cylinder.
struct Obstacle {
  Eigen::Vector3d centre;
  Eigen::Matrix3d axes;  ///< its columns, in the world
  Eigen::Vector3d half;  ///< of the box
  double radius;         ///< of the edges; 0 for a box
  double disc;           ///< of a cylinder about y: its radius; otherwise 0
  std::size_t object;

  /// Of a point from the box without its edges, or from the cylinder, squared.
  double SquaredDistance(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d local = axes.transpose() * (point - centre);
    if (disc > 0)
      return Eigen::Vector2d(std::hypot(local.x(), local.z()) - disc,
                             std::abs(local.y()) - half.y())
          .cwiseMax(0)
          .squaredNorm();
    return (local.cwiseAbs() - half).cwiseMax(0).squaredNorm();
  }
};

struct BallModel {
  struct Link {
    std::size_t object;
    std::vector<Ball> balls;
    Ball bound;  ///< contains them
  };
  std::vector<Link> links;  ///< those that move and have shapes, in the order of the tree
  std::vector<Obstacle> obstacles;
  /// Indices of a link, and of an obstacle or another link, that may touch.
  std::vector<std::pair<std::size_t, std::size_t>> with_obstacles, with_links;
};

/// Throws library::SceneError if a link is more than balls, or something fixed is another shape.
BallModel BallModelOf(const plan::Scene& scene, const layouts::InitialState& state,
                      const KinematicTree& tree);

/// Whether the robot hits itself or an obstacle, by all pairs of shapes in double; touching counts.
/// The truth of LaneChecker.
bool HitsInDouble(const BallModel& model, const std::vector<layouts::ObjectState>& objects,
                  const std::vector<objects::Pose>& poses);

/// The same by the referee (library/exact/signed_distance.h); nullopt if it is not certain.
std::optional<bool> HitsExactly(const BallModel& model,
                                const std::vector<layouts::ObjectState>& objects,
                                const std::vector<objects::Pose>& poses);

}  // namespace cdb::robots
