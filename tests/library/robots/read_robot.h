// What tests of robots ask of one that was read, and why one was not.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <vector>

#include "compiler/analysis/robot.h"
#include "library/robots/reader.h"

namespace cdb::tests {

inline Eigen::Isometry3d MotionOf(const analysis::RobotJoint& joint, double position) {
  using Type = analysis::RobotJoint::Type;
  if (joint.type == Type::kSlider)
    return Eigen::Isometry3d(Eigen::Translation3d(position * joint.axis));
  if (joint.type != Type::kHinge) return Eigen::Isometry3d::Identity();
  return Eigen::Translation3d(joint.pivot) * Eigen::AngleAxisd(position, joint.axis) *
         Eigen::Translation3d(-joint.pivot);
}

/// The frames of its links in that of the root, with each joint at `start`.
inline std::vector<Eigen::Isometry3d> FramesOf(const analysis::Robot& robot) {
  std::vector<Eigen::Isometry3d> frames(robot.links.size(), Eigen::Isometry3d::Identity());
  for (const analysis::RobotJoint& joint : robot.joints)
    frames[joint.child] = frames[joint.parent] * joint.origin * MotionOf(joint, joint.start);
  return frames;
}

/// Its index; the number of links without one.
inline std::size_t LinkAt(const analysis::Robot& robot, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(robot.links, name, &analysis::RobotLink::name) -
                                  robot.links.begin());
}

/// Of a text that stands for `file`: a line for each fault, empty if it was read.
inline std::string FaultsOf(const std::string& text, const std::string& file) {
  std::vector<analysis::RobotFault> faults;
  const auto robot = robots::ParseRobot(text, file, {}, faults);
  EXPECT_EQ(robot.has_value(), faults.empty());
  std::string all;
  for (const analysis::RobotFault& fault : faults) all += fault.cause + "; " + fault.remedy + "\n";
  return all;
}

}  // namespace cdb::tests
