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

std::vector<std::string> RefusedOf(const Robot& robot) {
  std::vector<std::string> massless, still, all;
  bool have_shapes = true;
  for (std::size_t i = 1; i < robot.links.size(); ++i) {  // the root may be fixed
    const RobotLink& link = robot.links[i];
    if (!link.inertia) {
      massless.push_back(link.name);
      have_shapes = have_shapes && !link.shapes.empty();
    } else if (!(link.inertia->tensor.trace() > 0)) {
      still.push_back(link.name);
    }
  }
  if (!massless.empty())
    all.push_back(fmt::format("{} can move, but {} no mass{}", fmt::join(massless, ", "),
                              massless.size() == 1 ? "has" : "have",
                              have_shapes ? ", unless the block of the robot has a density" : ""));
  if (!still.empty())
    all.push_back(fmt::format("{} {} a mass, but the inertia 0", fmt::join(still, ", "),
                              still.size() == 1 ? "has" : "have"));
  for (const RobotLink& link : robot.links)
    for (const RobotShape& shape : link.shapes)
      if (shape.is_missing) {
        all.push_back("meshes are missing; the block of the robot may name the folder of packages");
        return all;
      }
  return all;
}

}  // namespace cdb::robots
