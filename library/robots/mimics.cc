#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "library/robots/reader.h"

namespace cdb::robots {

using analysis::Robot;
using analysis::RobotJoint;
using Eigen::Isometry3d;

namespace {

RobotJoint* Find(Robot& robot, const std::string& name) {
  const auto found = std::ranges::find(robot.joints, name, &RobotJoint::name);
  return found == robot.joints.end() ? nullptr : &*found;
}

/// Why the joint cannot mimic; empty if it can.
std::string FaultOf(Robot& robot, const RobotJoint& joint) {
  const RobotJoint* other = Find(robot, joint.mimic);
  if (other == nullptr) return "which the robot does not have";
  if (other->type == RobotJoint::Type::kFree) return "which is floating";
  if (other->type == RobotJoint::Type::kBall || other->type == RobotJoint::Type::kUniversal)
    return "which has no position";
  std::size_t steps = 0;
  while (other != nullptr && !other->mimic.empty() && steps++ < robot.joints.size())
    other = Find(robot, other->mimic);
  return steps > robot.joints.size() || other == &joint ? "and so itself in the end" : "";
}

/// The largest limits that keep `driver` and what follows it within theirs; the follower whose
/// limits exclude all positions in `excluded`.
struct Range {
  double lower, upper;
  const RobotJoint* excluded = nullptr;
};
Range RangeOf(Robot& robot, const RobotJoint& driver) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  Range range = {driver.limits ? driver.limits->first : -kInfinite,
                 driver.limits ? driver.limits->second : kInfinite};
  for (const RobotJoint& joint : robot.joints) {
    if (joint.mimic.empty() || !joint.limits) continue;
    double ratio = joint.multiplier, offset = joint.offset;
    const RobotJoint* at = Find(robot, joint.mimic);
    for (; !at->mimic.empty(); at = Find(robot, at->mimic)) {
      offset += ratio * at->offset;
      ratio *= at->multiplier;
    }
    if (at != &driver) continue;
    const double first = (joint.limits->first - offset) / ratio,
                 second = (joint.limits->second - offset) / ratio;
    // Limits that are the same but for rounding narrow nothing.
    const double slack = 1e-9 * (1 + std::max(std::abs(first), std::abs(second)));
    const auto [lower, upper] = std::minmax(first, second);
    if (lower > range.lower + slack) range.lower = lower;
    if (upper < range.upper - slack) range.upper = upper;
    if (range.lower > range.upper && range.excluded == nullptr) range.excluded = &joint;
  }
  return range;
}

}  // namespace

void HoldAt(RobotJoint& joint, bool is_slider, double position) {
  joint.type = RobotJoint::Type::kFixed;
  joint.limits.reset();
  joint.mimic.clear();
  joint.start = position;
  if (position != 0)
    joint.origin =
        joint.origin *
        (is_slider ? Isometry3d(Eigen::Translation3d(position * joint.axis))
                   : Eigen::Translation3d(joint.pivot) * Eigen::AngleAxisd(position, joint.axis) *
                         Eigen::Translation3d(-joint.pivot));
}

void ResolveMimics(Robot& robot,
                   const std::function<void(const RobotJoint& joint, const std::string& cause,
                                            const char* remedy)>& report) {
  for (const RobotJoint& joint : robot.joints) {
    if (joint.mimic.empty()) continue;
    const std::string fault = FaultOf(robot, joint);
    if (!fault.empty())
      return report(joint, fmt::format("joint {} mimics {}, {}", joint.name, joint.mimic, fault),
                    "name a hinge or a slider that mimics none, or none of "
                    "this circle");
  }
  for (bool again = true; again;) {
    again = false;
    for (RobotJoint& joint : robot.joints) {
      if (joint.mimic.empty()) continue;
      const RobotJoint& other = *Find(robot, joint.mimic);
      if (joint.multiplier != 0 && other.type != RobotJoint::Type::kFixed) continue;
      robot.notes.push_back(
          fmt::format("joint {} is fixed, as what it mimics stands still", joint.name));
      HoldAt(joint, joint.type == RobotJoint::Type::kSlider,
             joint.multiplier * other.start + joint.offset);
      again = true;
    }
  }
  for (RobotJoint& joint : robot.joints) {
    if (!joint.mimic.empty() || joint.type == RobotJoint::Type::kFixed) continue;
    const auto [lower, upper, excluded] = RangeOf(robot, joint);
    if (excluded != nullptr)
      return report(*excluded,
                    fmt::format("no position of joint {} keeps it and {}, which mimics it, within "
                                "their limits",
                                joint.name, excluded->name),
                    "correct <mimic> or <limit>");
    if (lower <= joint.start && upper >= joint.start) continue;
    joint.start = std::isfinite(lower) && std::isfinite(upper) ? (lower + upper) / 2
                  : lower > joint.start                        ? lower
                                                               : upper;
  }
}

}  // namespace cdb::robots
