// A robot of the links and joints of a file, in any format: checks, meshes, and the order of links.
//
// Errors: faults, with file and line. Threads: any, each builder by one at a time.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/robot.h"

namespace cdb::robots {

/// Larger lengths, masses and moments are errors of units.
inline constexpr double kLargest = 1e9;
/// Whether all are numbers of at most kLargest.
bool IsInRange(const Eigen::Vector3d& v);

/// A joint between links by their names.
struct NamedJoint {
  analysis::RobotJoint joint;
  std::string parent, child;
  std::size_t child_line = 0;
};

class RobotBuilder {
 public:
  RobotBuilder(const std::string& path, const analysis::RobotOptions& options,
               std::vector<analysis::RobotFault>& faults)
      : path_(path), options_(options), faults_(faults) {}

  const std::string& path() const { return path_; }
  const analysis::RobotOptions& options() const { return options_; }
  void Report(std::size_t line, const std::string& cause, const std::string& remedy);
  void Note(std::string text) { robot_.notes.push_back(std::move(text)); }
  /// Counts what is not taken over.
  void Leave(const std::string& what) { ++left_out_[what]; }

  /// `tensor`: about the centre of mass, along the axes of `pose`, which is in the frame of the
  /// link. Nullopt without mass, and after a fault.
  std::optional<analysis::RobotInertia> InertiaOf(const analysis::RobotLink& link, double mass,
                                                  const Eigen::Isometry3d& pose,
                                                  const Eigen::Matrix3d& tensor);
  /// `written`: the name of its file in the file of the robot.
  analysis::RobotShape MeshOf(const std::string& written, const Eigen::Vector3d& scale) const;
  void AddShape(analysis::RobotLink& link, analysis::RobotShape shape);
  void AddLink(analysis::RobotLink link) { links_.push_back(std::move(link)); }
  /// Scales the masses and inertias of all links.
  void SetTotalMass(double mass);

  // Of a joint, whose type, name and line are set.

  /// False after a fault.
  bool SetAxis(analysis::RobotJoint& joint, Eigen::Vector3d& axis, const Eigen::Vector3d& value);
  void SetDynamics(analysis::RobotJoint& joint, double damping, double friction);
  /// Infinite ones are none. Equal ones fix the joint.
  void SetLimits(analysis::RobotJoint& joint, double lower, double upper);
  void SetMimic(analysis::RobotJoint& joint, const std::string& followed, double multiplier,
                double offset);
  void AddJoint(NamedJoint joint) { joints_.push_back(std::move(joint)); }

  void Disable(std::string first, std::string second) {
    robot_.disabled.emplace_back(std::move(first), std::move(second));
  }

  /// Links follow their parents, children in the order of their joints. Nullopt after faults.
  std::optional<analysis::Robot> Finish(std::string name);

 private:
  bool Arrange();
  bool HasOneParentEach();

  const std::string& path_;
  const analysis::RobotOptions& options_;
  std::vector<analysis::RobotFault>& faults_;
  const std::size_t before_ = faults_.size();
  analysis::Robot robot_;
  std::vector<analysis::RobotLink> links_;
  std::vector<NamedJoint> joints_;
  std::map<std::string, int> left_out_;
};

/// Faults for the links of which one principal moment is more than the sum of the others.
void RefuseOddInertias(const analysis::Robot& robot, const std::string& path,
                       std::vector<analysis::RobotFault>& faults);

void Scale(analysis::RobotInertia& inertia, double factor);
/// m^3; of a shape that is no mesh.
double VolumeOf(const analysis::RobotShape& shape);
/// Of a homogeneous body of that shape, in the frame of its link.
analysis::RobotInertia InertiaOf(const analysis::RobotShape& shape, double mass);

// The readers of each format. Throw library::SceneError, or add faults, for what they refuse.

/// Whether this build has urdfdom.
bool HasUrdf();
std::optional<analysis::Robot> ReadUrdf(const std::string& text, RobotBuilder& builder,
                                        std::vector<analysis::RobotFault>& faults);
/// Whether this build has pugixml.
bool HasXml();
std::optional<analysis::Robot> ReadSdf(const std::string& text, RobotBuilder& builder,
                                       std::vector<analysis::RobotFault>& faults);
std::optional<analysis::Robot> ReadMjcf(const std::string& text, RobotBuilder& builder,
                                        std::vector<analysis::RobotFault>& faults);

}  // namespace cdb::robots
