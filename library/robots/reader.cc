#include "library/robots/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>

#include "compiler/plan/input_file.h"
#include "library/robots/builder.h"
#include "library/robots/outline.h"
#include "library/scene_error.h"

namespace cdb::robots {

using analysis::Robot;
using analysis::RobotFault;
using analysis::RobotLink;
using analysis::RobotOptions;

namespace {

/// A row for each format, in the order of Format.
struct Row {
  std::string_view root, extension;
  bool (*is_built)();
  std::optional<Robot> (*read)(const std::string& text, RobotBuilder& builder,
                               std::vector<RobotFault>& faults);
};
constexpr Row kRows[] = {{"robot", ".urdf", HasUrdf, ReadUrdf},
                         {"sdf", ".sdf", HasXml, ReadSdf},
                         {"mujoco", ".xml", HasXml, ReadMjcf}};

const Row& RowOf(const std::string& text, const std::string& path) {
  const std::vector<Element> elements = ReadOutline(text, path);
  const auto fail = [&](const std::string& cause) {
    throw library::SceneError(
        fmt::format("{}:{}: {}", path, elements.empty() ? 1 : elements[0].line, cause),
        "a file of a robot begins with <robot name=\"…\"> (URDF), <sdf> or <mujoco> (MJCF)");
  };
  if (elements.empty()) fail("has no elements");
  const auto* row = std::ranges::find(kRows, elements[0].name, &Row::root);
  if (row == std::end(kRows))
    fail(fmt::format("begins with <{}>, which is no robot", elements[0].name));
  return *row;
}

/// `disable_collisions` of an SRDF file.
void ReadSrdf(const std::string& path, Robot& robot) {
  std::string why;
  const auto text = plan::ReadInputFile(path, why, kMaxRobotBytes);
  if (!text)
    throw library::SceneError(fmt::format("cannot read '{}': {}", path, why),
                              "its path is relative to the folder of the .cdb file");
  for (const Element& element : ReadOutline(*text, path)) {
    if (element.name != "disable_collisions") continue;
    std::pair<std::string, std::string> links(element.Attribute("link1"),
                                              element.Attribute("link2"));
    for (const std::string& link : {links.first, links.second})
      if (std::ranges::find(robot.links, link, &RobotLink::name) == robot.links.end())
        throw library::SceneError(
            fmt::format("{}:{}: there is no link {}", path, element.line, link),
            "the SRDF file belongs to another robot");
    robot.disabled.push_back(std::move(links));
  }
}

std::optional<Robot> Parse(const std::string& text, const std::string& path,
                           const RobotOptions& options, std::vector<RobotFault>& faults) {
  RobotBuilder builder(path, options, faults);
  auto robot = RowOf(text, path).read(text, builder, faults);
  if (robot && !options.srdf.empty()) ReadSrdf(options.srdf, *robot);
  return robot;
}

}  // namespace

bool HasReader(Format format) { return kRows[static_cast<std::size_t>(format)].is_built(); }

bool IsRobotFile(std::string_view name) {
  const std::string extension = std::filesystem::path(name).extension().string();
  return std::ranges::find(kRows, extension, &Row::extension) != std::end(kRows);
}

std::optional<Robot> ParseRobot(const std::string& text, const std::string& path,
                                const RobotOptions& options, std::vector<RobotFault>& faults) {
  const std::size_t before = faults.size();
  try {
    auto robot = Parse(text, path, options, faults);
    if (robot) *robot = MergeFixed(*robot, !options.merges);
    // Links that are held together have the inertia of one body.
    if (robot && !options.takes_any_inertia) RefuseOddInertias(*robot, path, faults);
    return faults.size() == before ? robot : std::nullopt;
  } catch (const library::SceneError& error) {
    faults.push_back({error.cause(), error.remedy()});
  } catch (const std::exception& error) {
    faults.push_back({fmt::format("{}: {}", path, error.what()), ""});
  }
  return std::nullopt;
}

std::optional<Robot> ReadRobot(const std::string& path, const RobotOptions& options,
                               std::vector<RobotFault>& faults) {
  std::string why;
  const auto text = plan::ReadInputFile(path, why, kMaxRobotBytes);
  if (text) {
    auto robot = ParseRobot(*text, path, options, faults);
    if (robot) robot->summary = SummaryOf(*robot, path);
    return robot;
  }
  faults.push_back({fmt::format("cannot read '{}': {}", path, why),
                    "the path is relative to the folder of the .cdb file",
                    RobotFault::Kind::kMissing});
  return std::nullopt;
}

}  // namespace cdb::robots
