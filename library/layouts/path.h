// Motion of kinematic objects: along a path from a file, `location path("lift.csv")`, or with
// constant velocities. A function of time alone, so that it is the same with every time step.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "compiler/analysis/poses.h"
#include "library/layouts/pose_table.h"

namespace cdb::layouts {

/// Poses at times. Between them, positions are interpolated linearly and orientations by spherical
/// linear interpolation, along the shorter arc. Before the first time the first pose applies; after
/// the last time the last pose applies, or the path repeats. m, s; unit quaternions, the rotation
/// of `orientation`. Threads: any.
class Path {
 public:
  /// `table` must have at least one row, with rows in ascending order of time. Throws SceneError if
  /// the path repeats and does not end where it begins.
  Path(const schema::Call& call, const PoseTable& table);

  bool has_orientation() const { return has_orientation_; }
  Eigen::Vector3d PositionAt(double time) const;
  /// The identity if the table has no orientations.
  Eigen::Quaterniond OrientationAt(double time) const;

 private:
  /// Two rows, and the fraction of the distance from the first to the second.
  struct Between {
    const PoseRow *from, *to;
    double part;
  };
  Between At(double time) const;

  std::vector<PoseRow> rows_;
  bool has_orientation_ = false, repeats_ = false;
};

/// The path named in a call of the plan. Throws SceneError if the file differs from the one at
/// planning.
Path ReadPath(const schema::Call& call);
/// The facts about the path for the compiler: one object, with velocity.
analysis::PoseFacts FactsOfPath(const Path& path, const std::string& sha256);

}  // namespace cdb::layouts
