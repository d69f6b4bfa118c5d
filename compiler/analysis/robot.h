// A robot read from a file: links held together by joints. The compiler makes groups of objects and
// joints of it; the library reads it (library/robots/reader.h).
//
// SI units; frames, axes and coordinates are those of the file, in which z is up.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cdb::analysis {

struct RobotShape {
  enum class Kind { kBox, kSphere, kCylinder, kCapsule, kEllipsoid, kMesh };
  Kind kind = Kind::kBox;
  /// Along its own axes; that of a cylinder or a capsule is z. Of a mesh, the factors of its
  /// coordinates.
  Eigen::Vector3d sides = Eigen::Vector3d::Ones();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the frame of its link
  std::string written, file;  ///< of a mesh: in the robot's file; its path
  bool is_missing = false;    ///< that path does not exist
  /// The reader of the mesh turns its coordinates (x, y, z) to (x, z, -y), as the mesh says that z
  /// is up.
  bool is_turned = false;
};

struct RobotInertia {
  double mass = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d tensor = Eigen::Matrix3d::Zero();  ///< about the centre, along the link's axes
};

struct RobotLink {
  std::string name;
  std::size_t line = 0;
  std::optional<RobotInertia> inertia;
  std::vector<RobotShape> shapes;
  std::vector<std::string> parts;  ///< names of the links that became one with it by fixed joints
  /// No mass and no shapes.
  bool IsFrame() const { return !inertia && shapes.empty(); }
};

struct RobotJoint {
  enum class Type { kFixed, kHinge, kSlider, kFree, kBall, kUniversal };
  std::string name;
  std::size_t line = 0;
  Type type = Type::kFixed;
  std::size_t parent = 0, child = 0;  ///< links
  /// Of the frame of the child, at position 0, in the frame of the parent.
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
  /// In the frame of the child at position 0; axis2: of a universal joint, the axis of the child.
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitX(),
                  axis2 = Eigen::Vector3d::UnitY();
  std::optional<std::pair<double, double>> limits;  ///< rad or m
  /// The joint that it follows, at `multiplier` times its position plus `offset`; empty: none.
  std::string mimic = {};
  double multiplier = 1, offset = 0;
  /// Unless the user gives another: that of the file, 0 in most, or in the middle of limits that
  /// exclude it, its own and those of joints that follow it. Of a fixed joint, where it is held.
  double start = 0;
  double damping = 0, friction = 0;
  double effort = 0, velocity = 0;  ///< the largest ones of its motor; 0: not given
  double armature = 0;              ///< kg m^2, or kg
};

struct Robot {
  std::string name;
  std::vector<RobotLink> links;    ///< a parent precedes its children; the first one is the root
  std::vector<RobotJoint> joints;  ///< joint i holds link i + 1
  /// Pairs of links that do not collide, by their names: of MJCF, and of an SRDF file.
  std::vector<std::pair<std::string, std::string>> disabled;
  std::vector<std::string> notes;     ///< about what was changed
  std::vector<std::string> left_out;  ///< `12 visual`
  std::string summary;                ///< of `cdb check`: lines
};

struct RobotOptions {
  std::string packages;  ///< the folder in which `package://` is searched for first; may be empty
  std::string srdf;      ///< a file; may be empty
  bool merges = true;    ///< links held by fixed joints become one; otherwise only frames do
  /// Takes inertias of which one moment is more than the sum of the others.
  bool takes_any_inertia = false;
  /// Links of a small mass stand between the joints of a body that has several.
  bool has_dummy_links = false;
  bool operator==(const RobotOptions&) const = default;
};

struct RobotFault {
  enum class Kind {
    kWrong,
    kMissing,      ///< a file is not on this machine
    kUnavailable,  ///< this build reads no robots
  };
  std::string cause, remedy;  ///< `cause` begins with the file and the line
  Kind kind = Kind::kWrong;
};

/// Reads the robot of a file; nullopt if it has faults. A function, so that the compiler knows no
/// file format.
using ReadRobot = std::function<std::optional<Robot>(
    const std::string& path, const RobotOptions& options, std::vector<RobotFault>& faults)>;

}  // namespace cdb::analysis
