// Robots from files: URDF by urdfdom, SDF and MJCF by pugixml.
//
// Each reader makes its links and joints by a RobotBuilder (builder.h). What a reader does not take
// over is listed. Errors: faults, with file and line; nothing is thrown, and nothing is printed.
// Threads: any.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/analysis/robot.h"

namespace cdb::robots {

enum class Format { kUrdf, kSdf, kMjcf };
/// Whether this build can read it.
bool HasReader(Format format);

/// Whether the extension is one of a robot's file, such as `.urdf`.
bool IsRobotFile(std::string_view name);

/// analysis::ReadRobot.
std::optional<analysis::Robot> ReadRobot(const std::string& path,
                                         const analysis::RobotOptions& options,
                                         std::vector<analysis::RobotFault>& faults);
/// The same of a text, whose root element states its format; `path` stands for its file, whose
/// folder its meshes are relative to.
std::optional<analysis::Robot> ParseRobot(const std::string& text, const std::string& path,
                                          const analysis::RobotOptions& options,
                                          std::vector<analysis::RobotFault>& faults);

/// The text of `cdb check FILE`: links, joints, masses, shapes, and what was left out.
std::string SummaryOf(const analysis::Robot& robot, const std::string& path);
/// Why every scene refuses the robot, unless its block says otherwise; empty if none does.
std::vector<std::string> RefusedOf(const analysis::Robot& robot);

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
