// The possible positions of each object: on its trajectory until its first possible contact, in a
// growing region from then on.
//
// SI units. Errors: none. Threads: one.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/omissions/trajectory.h"

namespace cdb::omissions {

/// All points within `radius` of a box.
struct Ball {
  Box core;
  double radius;
};

Box Grown(const Box& box, double by);

/// The positions that the centre of an object may have after its first possible contact: a box
/// that moves uniformly or falls, and all points within `Radius` of it.
struct Region {
  double since = 0;
  Box core;                 ///< at `since`
  Eigen::Vector3d drift;    ///< m/s
  Eigen::Vector3d gravity;  ///< 0 in the world frame
  double timestep = 0;
  double radius = 0;                     ///< m, at `since`
  double rate = 0, more = 0, limit = 0;  ///< it grows by min(rate + more t, limit)
  double error = 0;                      ///< m: rounding

  double Radius(double time) const;
  Box Core(double time) const;
  /// A box that contains the region until `time`.
  Box Hull(double time) const;
};

class ObjectMotions {
 public:
  /// The arguments must outlive the object.
  ObjectMotions(const std::vector<Trajectory>& trajectories, const Eigen::Vector3d& acceleration,
                const Horizon& horizon);

  const Trajectory& trajectory(std::size_t object) const { return trajectories_[object]; }
  bool IsFixed(std::size_t object) const { return trajectory(object).motion == Motion::kFixed; }

  /// Call when the object has a contact, the first or a later one.
  void SetRegion(std::size_t object, const Region& region);
  /// 0 in free flight; each new region changes it.
  std::uint32_t version(std::size_t object) const { return versions_[object]; }
  bool IsInFlight(std::size_t object) const { return version(object) == 0; }
  /// The region of an object that is not in free flight.
  const Region& region(std::size_t object) const { return regions_[object]; }

  /// The possible positions of the object's centre at `time`.
  Ball BallAt(std::size_t object, double time) const;
  /// m: the rounding error of BallAt.
  double ErrorOf(std::size_t object) const;
  /// m/s: bound of the speed of the surface of BallAt, in the world and in the falling frame.
  double FastestInWorld(std::size_t object) const;
  double FastestInAir(std::size_t object) const;

 private:
  const std::vector<Trajectory>& trajectories_;
  const double fall_;                    ///< m/s: velocity that gravity adds until the end
  std::vector<std::uint32_t> versions_;  ///< by object
  std::vector<Region> regions_;          ///< by object
};

}  // namespace cdb::omissions
