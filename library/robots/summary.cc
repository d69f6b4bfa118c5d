#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "library/robots/reader.h"

namespace cdb::robots {

using analysis::Robot;
using analysis::RobotJoint;
using analysis::RobotLink;
using analysis::RobotShape;

namespace {

std::string Counted(const std::map<std::string, int>& counts) {
  std::vector<std::string> texts;
  for (const auto& [what, count] : counts) texts.push_back(fmt::format("{} {}", count, what));
  return texts.empty() ? "none" : fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace

std::string SummaryOf(const Robot& robot, const std::string& path) {
  double mass = 0;
  std::map<std::string, int> joints, shapes;
  std::vector<std::string> names, massless, merged, missing;
  std::map<std::string, std::vector<std::string>> joint_names;
  for (const RobotLink& link : robot.links) {
    names.push_back(link.name);
    mass += link.inertia ? link.inertia->mass : 0;
    if (!link.inertia) massless.push_back(link.name);
    if (!link.parts.empty())
      merged.push_back(fmt::format("{} ({})", link.name, fmt::join(link.parts, ", ")));
    for (const RobotShape& shape : link.shapes) {
      constexpr const char* kNames[] = {"box",     "sphere",    "cylinder",
                                        "capsule", "ellipsoid", "mesh"};
      ++shapes[kNames[static_cast<int>(shape.kind)]];
      if (shape.is_missing && std::ranges::find(missing, shape.file) == missing.end())
        missing.push_back(shape.file);
    }
  }
  for (const RobotJoint& joint : robot.joints) {
    constexpr const char* kNames[] = {"fixed", "hinge", "slider", "free", "ball", "universal"};
    const char* type = kNames[static_cast<int>(joint.type)];
    ++joints[type];
    joint_names[type].push_back(joint.name);
  }
  std::string text =
      fmt::format("{}: robot {}: {} bodies, {:.6g} kg; joints: {}; shapes: {}\n", path, robot.name,
                  robot.links.size(), mass, Counted(joints), Counted(shapes));
  const auto list = [&](const char* what, const std::vector<std::string>& items) {
    if (!items.empty()) text += fmt::format("  {}: {}\n", what, fmt::join(items, ", "));
  };
  list("bodies", names);
  for (const auto& [type, of_type] : joint_names) list(type.c_str(), of_type);
  list("held by fixed joints, and one body", merged);
  list("without mass", massless);
  list("missing meshes", missing);
  for (const std::string& note : robot.notes) text += fmt::format("  {}\n", note);
  list("not taken over", robot.left_out);
  return text;
}

}  // namespace cdb::robots
