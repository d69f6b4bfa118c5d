// How kinematic objects move: along a path from a file, `location path("lift.csv")`, or with
// constant velocities. A function of time alone, so that it is the same in every time step.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "compiler/analysis/poses.h"
#include "library/layouts/pose_table.h"

namespace cdb::layouts {

/// Poses at times. Between two of them positions are interpolated linearly and orientations by
/// spherical linear interpolation, along the shorter way; before the first time the first pose
/// holds, after the last one the last, or the path repeats. m, s; unit quaternions, the turn of
/// `orientation`. Threads: any.
class Path {
 public:
  /// `table` has a row at least, in the order of the times. Throws SceneError where the path
  /// repeats and does not end where it begins.
  Path(const schema::Call& call, const PoseTable& table);

  bool has_orientation() const { return has_orientation_; }
  Eigen::Vector3d PositionAt(double time) const;
  /// The identity where the table has none.
  Eigen::Quaterniond OrientationAt(double time) const;

 private:
  /// Two rows, and how far from the first to the second.
  struct Between {
    const PoseRow *from, *to;
    double part;
  };
  Between At(double time) const;

  std::vector<PoseRow> rows_;
  bool has_orientation_ = false, repeats_ = false;
};

/// The path that a call of the plan names. Refuses another file than the one that was planned with.
Path ReadPath(const schema::Call& call);
/// The path in the compiler's terms: one object, whose velocity it gives.
analysis::PoseFacts FactsOfPath(const Path& path, const std::string& sha256);

}  // namespace cdb::layouts
