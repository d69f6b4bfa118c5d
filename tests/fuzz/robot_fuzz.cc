// Any bytes, read as a robot in URDF, SDF or MJCF: the result is a fault that names the file, or a
// tree of links with finite frames and masses above 0; then its links are merged as well.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "dsl/text/check.h"
#include "library/robots/reader.h"

// urdfdom keeps the links of a circle for good.
extern "C" const char* __lsan_default_suppressions() { return "leak:liburdfdom"; }

namespace {

using namespace cdb;

void CheckRobot(const analysis::Robot& robot) {
  CDB_CHECK(!robot.links.empty() && robot.joints.size() + 1 == robot.links.size());
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const analysis::RobotJoint& joint = robot.joints[i];
    CDB_CHECK(joint.child == i + 1 && joint.parent <= i);
    CDB_CHECK(joint.origin.matrix().allFinite() && std::abs(joint.axis.norm() - 1) < 1e-9);
    CDB_CHECK(joint.pivot.allFinite() && std::isfinite(joint.start));
    CDB_CHECK(!joint.limits || joint.limits->first < joint.limits->second);
    CDB_CHECK(joint.damping >= 0 && joint.friction >= 0);
  }
  for (const analysis::RobotLink& link : robot.links) {
    if (link.inertia) {
      CDB_CHECK(link.inertia->mass > 0 && link.inertia->centre.allFinite());
      CDB_CHECK(link.inertia->tensor.allFinite());
    }
    for (const analysis::RobotShape& shape : link.shapes)
      CDB_CHECK(shape.pose.matrix().allFinite() && shape.sides.cwiseAbs().minCoeff() > 0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  for (const bool merges : {false, true}) {
    std::vector<analysis::RobotFault> faults;
    const auto robot = robots::ParseRobot(text, "fuzz.xml",
                                          {.packages = {}, .srdf = {}, .merges = merges}, faults);
    CDB_CHECK(robot.has_value() == faults.empty());
    for (const analysis::RobotFault& fault : faults)
      CDB_CHECK(fault.cause.starts_with("fuzz.xml:"));
    if (robot) CheckRobot(*robot);
  }
  return 0;
}
