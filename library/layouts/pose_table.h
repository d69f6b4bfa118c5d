// Positions, orientations and velocities of a group's objects from a file: `location
// poses("start.csv")`.
//
// A CSV file begins with a line of column names: x, y, z (m, the centre of mass), and where they
// are given qw, qx, qy, qz (unit quaternion, the turn of `orientation`), vx, vy, vz (m/s) and wx,
// wy, wz (rad/s). One line for each object; empty lines and lines that begin with # are skipped.
// Errors: SceneError with the file, the line, the cause and the remedy. Threads: any, but for
// SetPoseReader. Source: RFC 4180, without quotes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/poses.h"

namespace cdb::layouts {

struct PoseRow {
  double time = 0;  ///< s; of a path
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
};

struct PoseTable {
  bool has_orientation = false, has_linear_velocity = false, has_angular_velocity = false;
  /// Orientations are of the bodies' own axes, as a recorded run has them, instead of the turn of
  /// `orientation`; they differ for compounds.
  bool of_body = false;
  std::vector<PoseRow> rows;
};

/// `name` stands for the file.
PoseTable ParsePoseCsv(std::string_view csv, std::string_view name);
/// A path: the columns t (s, ascending), x, y, z, and qw, qx, qy, qz where they are given.
PoseTable ParsePathCsv(std::string_view csv, std::string_view name);
/// Reads back to the same table, but for `of_body`.
std::string ToCsv(const PoseTable& table);
/// The unit quaternion of four numbers that are one but for rounding; nullopt where they are none.
std::optional<Eigen::Quaterniond> UnitQuaternion(double w, double x, double y, double z);

/// The table of a call of the plan. Refuses another file than the one that was planned with.
PoseTable ReadPoseTable(const schema::Call& poses);
/// The same in the compiler's terms, of a path too, which is one object's; the hash is not
/// compared.
std::optional<analysis::PoseFacts> ReadPoseFacts(const schema::Call& poses,
                                                 analysis::PoseFault& why);

/// How HDF5 files are read in this process; without one they are refused. Set it before anything is
/// read.
using ReadHdf5Poses = std::function<PoseTable(const schema::Call& poses)>;
void SetPoseReader(ReadHdf5Poses reader);

/// The tables of the scene that are in HDF5 files, as one text for a process that cannot read them;
/// empty where there is none.
std::string PackPoses(const plan::Scene& scene);
/// A table of that text.
PoseTable UnpackPoses(std::string_view packed, const schema::Call& poses);

}  // namespace cdb::layouts
