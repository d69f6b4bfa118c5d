// Positions, orientations and velocities of a group's objects from a file, `location
// poses("start.csv")`, and the paths of kinematic objects, `location path("lift.csv")`: text with a
// line for each object or time (pose_columns.h, compiler/plan/text_table.h), or HDF5.
//
// Errors: SceneError with the file, the line, the cause and the remedy. Threads: any, except for
// SetPoseReader.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/trace.h"

namespace cdb::layouts {

struct PoseRow {
  double time = 0;  ///< s; only in a path
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
};

struct PoseTable {
  bool has_time = false, has_orientation = false, has_linear_velocity = false,
       has_angular_velocity = false;
  std::vector<PoseRow> rows;
};

/// The call `poses` or `path` of a file, with the defaults of its other arguments.
schema::Call TableCall(std::string_view name, std::string_view file);
/// `name` is the name of the file, for messages.
PoseTable ParsePoseCsv(std::string_view csv, std::string_view name);
/// A path: the columns t (s, ascending), x, y, z and, optionally, qw, qx, qy, qz.
PoseTable ParsePathCsv(std::string_view csv, std::string_view name);
/// Reads back to the same table.
std::string ToCsv(const PoseTable& table);
/// The unit quaternion of four numbers, up to rounding; nullopt if they are not one.
std::optional<Eigen::Quaterniond> UnitQuaternion(double w, double x, double y, double z);

/// The table named in a call of the plan. Throws SceneError if the file differs from the one at
/// planning.
PoseTable ReadPoseTable(const schema::Call& poses);
/// The facts about it for the compiler; also for a path, which counts as one object. The hash is
/// not compared.
std::optional<analysis::PoseFacts> ReadPoseFacts(const schema::Call& poses,
                                                 analysis::PoseFault& why);

/// The function that reads HDF5 files in this process; without one they are rejected. Set it before
/// reading anything.
using ReadHdf5Poses = std::function<PoseTable(const schema::Call& poses)>;
void SetPoseReader(ReadHdf5Poses reader);

/// The tables of the scene from HDF5 files, as one text for a process that cannot read these; empty
/// if there are none.
std::string PackPoses(const plan::Scene& scene);
/// A table from that text.
PoseTable UnpackPoses(std::string_view packed, const schema::Call& poses);

// Motion of kinematic objects: along a path from a file, `location path("lift.csv")`, or with
// constant velocities. A function of time alone, so that it is the same with every time step.

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
  const std::vector<PoseRow>& rows() const { return rows_; }
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
