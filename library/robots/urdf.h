// Robots from URDF files, by urdfdom.
//
// urdfdom reads links, joints, masses and collision shapes; what it does not need is removed before
// it reads the text, which is well-formed (outline.h). Errors: faults, with file and line; nothing
// is thrown, and nothing is printed. Threads: any; one at a time reads. Source:
// https://wiki.ros.org/urdf/XML
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/robot.h"

namespace cdb::robots {

/// Whether this build can read them.
bool HasReader();

/// analysis::ReadRobot.
std::optional<analysis::Robot> ReadUrdf(const std::string& path,
                                        const analysis::RobotOptions& options,
                                        std::vector<analysis::RobotFault>& faults);
/// The same of a text; `path` stands for its file, whose folder its meshes are relative to.
std::optional<analysis::Robot> ParseUrdf(const std::string& text, const std::string& path,
                                         const analysis::RobotOptions& options,
                                         std::vector<analysis::RobotFault>& faults);

/// The text of `cdb check FILE.urdf`: links, joints, masses, shapes, and what was left out.
std::string SummaryOf(const analysis::Robot& robot, const std::string& path);

// Joints that mimic others: mimics.cc.

/// Fixes a hinge or a slider at a position.
void HoldAt(analysis::RobotJoint& joint, bool is_slider, double position);

/// Fixes what follows a joint that cannot move, and chooses RobotJoint::start. `report` gets the
/// mimics that cannot be; then some joints may be left as they were.
void ResolveMimics(analysis::Robot& robot,
                   const std::function<void(const analysis::RobotJoint& joint,
                                            const std::string& cause, const char* remedy)>& report);

// Links that fixed joints hold.

/// The robot without fixed joints: a link and those that fixed joints hold to it are one, with the
/// frame of the first one and the name of the first one that is no frame. With `only_frames`, a
/// link with mass or shapes remains one.
analysis::Robot MergeFixed(const analysis::Robot& robot, bool only_frames);

/// The two bodies as one, in the frame of the first; `pose` is that of the second.
analysis::RobotInertia Together(const analysis::RobotInertia& first,
                                const analysis::RobotInertia& second,
                                const Eigen::Isometry3d& pose);

}  // namespace cdb::robots
