#include "compiler/analysis/configurations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string_view>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/joints.h"
#include "compiler/plan/input_file.h"
#include "compiler/plan/text_table.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/units.h"

namespace cdb::analysis {
namespace {

using Refused = std::optional<ConfigurationFault>;
using schema::GroupParameter;

constexpr auto kPositions =
    schema::ParameterRef<false, schema::ValueKind::kWord>("configurations.positions");

ConfigurationFault Refusal(const plan::Joint& joint, GroupParameter parameter, std::string message,
                           std::string help) {
  return {joint.name, parameter.get(), std::move(message), std::move(help)};
}

ConfigurationFault Refusal(const plan::Group& group, GroupParameter parameter, std::string message,
                           std::string help) {
  return {group.name, parameter.get(), std::move(message), std::move(help)};
}

std::string_view ChildOf(const plan::Joint& joint) { return joint.settings.WordOr("joints.child"); }
std::string_view ParentOf(const plan::Joint& joint) {
  return joint.settings.WordOr("joints.parent");
}

bool IsHeldStill(const plan::Group& group) { return group.settings.WordOr("mass") == "fixed"; }

/// Faults of one joint.
Refused FindFault(const plan::Scene& scene, const plan::Joint& joint) {
  const std::string_view type = joint.settings.WordOr("joints.type");
  if (type == "ball" || type == "universal")
    return Refusal(
        joint, "joints.type",
        fmt::format("{} is of the type {}, which no single position describes", TextOf(joint),
                    type),
        fmt::format("write {} hinges, with links between them", type == "ball" ? "three" : "two"));
  if (ChildOf(joint) == plan::kWorldWord)
    return Refusal(joint, "joints.child",
                   fmt::format("the child of {} is the world", TextOf(joint)),
                   "exchange parent and child: the parent holds the child");
  if (const plan::Group* parent = scene.FindGroup(ParentOf(joint));
      parent != nullptr && parent->settings.Count("quantity") > 1)
    return Refusal(joint, "joints.parent",
                   fmt::format("{} holds its child to {} objects: a loop, which configurations "
                               "cannot have",
                               TextOf(joint), parent->settings.Count("quantity")),
                   "let the parent be a single object");
  const plan::Group& child = *scene.FindGroup(ChildOf(joint));
  if (child.settings.Count("quantity") > 1)
    return Refusal(joint, "joints.child",
                   fmt::format("{} holds {} objects, but configurations are of one robot",
                               TextOf(joint), child.settings.Count("quantity")),
                   "write a block for each robot, with other names");
  if (IsHeldStill(child))
    return Refusal(joint, "joints.child",
                   fmt::format("{} holds {}, which is fixed: a loop, which configurations cannot "
                               "have",
                               TextOf(joint), child.name),
                   "exchange parent and child, or leave the joint out");
  return std::nullopt;
}

/// Every object that can move is held by one joint, and all of them by something fixed.
Refused FindTreeFault(const plan::Scene& scene) {
  std::map<std::string_view, const plan::Joint*> holders;
  for (const plan::Joint& joint : scene.joints) {
    if (!scene.HoldsObjects(joint)) continue;
    if (Refused fault = FindFault(scene, joint)) return fault;
    const auto [holder, is_first] = holders.emplace(ChildOf(joint), &joint);
    if (!is_first)
      return Refusal(joint, "joints.child",
                     fmt::format("{} and {} hold {}: a loop, which configurations cannot have",
                                 TextOf(*holder->second), TextOf(joint), ChildOf(joint)),
                     "leave one of them out");
  }
  for (const plan::Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0) continue;
    const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
    if (layout != nullptr && layout->name == "pile")
      return Refusal(group, "location", "a pile settles by simulation, which configurations lack",
                     "write another layout, or poses( ) of a run in which it has settled");
    if (HasKinematic(group))
      return Refusal(
          group, "mass",
          fmt::format("{} is kinematic, but nothing moves with time in configurations", group.name),
          "write mass fixed");
    if (!IsHeldStill(group) && !holders.contains(group.name))
      return Refusal(
          group, "mass",
          fmt::format("no joint holds {}, and configurations simulate nothing", group.name),
          "write mass fixed; for a robot whose base floats, base fixed");
    std::size_t joints = 0;
    for (auto at = holders.find(group.name); at != holders.end();
         at = holders.find(ParentOf(*at->second)))
      if (++joints > holders.size())
        return Refusal(
            *at->second, "joints.parent",
            fmt::format("{} is in a loop of joints, which configurations cannot have", group.name),
            "let the world, or a fixed object, be the first parent");
  }
  return std::nullopt;
}

/// Answers that are not available.
Refused FindAskFault(const plan::Scene& scene) {
  const schema::WorldParameter ask = "configurations.ask", record = "record";
  const bool is_by_lanes = scene.world.WordOr("configurations.by") == "lanes";
  const std::string_view asked = scene.world.WordOr("configurations.ask");
  if (is_by_lanes && asked != "hit")
    return ConfigurationFault{"", schema::WorldParameter("configurations.by").get(),
                              fmt::format("lanes find whether the robot hits, but not {}",
                                          asked == "contacts" ? "the contacts" : "the distance"),
                              "write ask hit, or by detector"};
  for (const char* word : {"contacts", "poses", "boxes"})
    if (is_by_lanes && scene.world.Lists("record", word))
      return ConfigurationFault{"", record.get(), fmt::format("lanes have no {} to record", word),
                                "remove it, or write configurations.by detector"};
  if (asked == "distance" && scene.world.WordOr("world.walls") != "none")
    return ConfigurationFault{"", ask.get(), "the distance to walls is not computed",
                              "write world.walls none, and boxes in their place"};
  return std::nullopt;
}

const plan::Joint& LastDriverOf(const plan::Scene& scene, const plan::Joint& joint) {
  const plan::Joint* at = &joint;
  while (const auto gear = GearOf(scene, *at)) at = gear->with;
  return *at;
}

/// What follows a freedom narrows its limits.
void LimitDrivers(std::vector<Freedom>& freedoms) {
  for (const Freedom& freedom : freedoms) {
    if (!freedom.driver || !freedom.has_limits) continue;
    Freedom& driver = freedoms[*freedom.driver];
    const double first = (freedom.lower - freedom.offset) / freedom.ratio,
                 second = (freedom.upper - freedom.offset) / freedom.ratio;
    // Limits that are the same but for rounding narrow nothing.
    const double slack = 1e-9 * (1 + std::max(std::abs(first), std::abs(second)));
    const auto [lower, upper] = std::minmax(first, second);
    if (lower > driver.lower + slack) driver.lower = lower;
    if (upper < driver.upper - slack) driver.upper = upper;
    driver.has_limits = true;
  }
  for (Freedom& freedom : freedoms) {
    if (freedom.is_slider || freedom.has_limits) continue;
    freedom.lower = -std::numbers::pi;
    freedom.upper = std::numbers::pi;
  }
}

/// Faults of the position of a joint.
Refused FindPositionFault(const plan::Scene& scene, const Freedom& freedom) {
  const plan::Joint& joint = *freedom.joint;
  if (freedom.driver && joint.settings.Has(*GroupParameter("joints.goal")))
    return Refusal(joint, "joints.goal",
                   fmt::format("{} follows {}, and has no goal of its own", TextOf(joint),
                               joint.settings.WordOr("joints.gear.with")),
                   "remove it");
  if (freedom.driver) return std::nullopt;
  const bool is_path = scene.world.WordOr(kPositions) == "path";
  if (scene.world.WordOr(kPositions) == "uniform" && !std::isfinite(freedom.lower))
    return Refusal(joint, "joints.type",
                   fmt::format("{} is a slider without limits, between which positions are drawn",
                               TextOf(joint)),
                   "give it limits: limits { lower 0; upper 1 }");
  if (is_path && (freedom.goal < freedom.lower || freedom.goal > freedom.upper) &&
      freedom.has_limits)
    return Refusal(joint, "joints.goal",
                   fmt::format("the goal of {}, {}, is outside its limits, {} to {}", TextOf(joint),
                               schema::FormatReal(freedom.goal), schema::FormatReal(freedom.lower),
                               schema::FormatReal(freedom.upper)),
                   "the path stays within the limits, also those of joints in gear with this one");
  return std::nullopt;
}

}  // namespace

bool HasConfigurations(const plan::Scene& scene) {
  return scene.world.WordOr(kPositions) != "none";
}

const schema::Call* ConfigurationListOf(const plan::Scene& scene) {
  return schema::AsCall(scene.world.Get(kPositions));
}

std::vector<Freedom> FreedomsOf(const plan::Scene& scene) {
  std::vector<Freedom> freedoms;
  std::map<const plan::Joint*, std::size_t> numbers;
  const auto moves = [&](const plan::Joint& joint) {
    return scene.world.Lists("configurations.of", "all") ||
           scene.world.Lists("configurations.of", joint.name);
  };
  for (const plan::Joint& joint : scene.joints) {
    const std::string_view type = joint.settings.WordOr("joints.type");
    if (!scene.HoldsObjects(joint) || (type != "hinge" && type != "slider")) continue;
    if (!moves(LastDriverOf(scene, joint))) continue;
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    Freedom freedom = {&joint, type == "slider", -kInfinite, kInfinite, HasLimits(joint), 0, 0};
    if (HasLimits(joint) &&
        schema::AsNumber(joint.settings.Get("joints.limits.upper")) != nullptr) {
      freedom.lower = joint.settings.Real("joints.limits.lower");
      freedom.upper = joint.settings.Real("joints.limits.upper");
    }
    freedom.start = joint.settings.Real("joints.start");
    const schema::Number* goal = schema::AsNumber(joint.settings.Get("joints.goal"));
    freedom.goal = goal == nullptr ? freedom.start : goal->AsReal();
    numbers.emplace(&joint, freedoms.size());
    freedoms.push_back(freedom);
  }
  for (Freedom& freedom : freedoms) {
    const plan::Joint* at = freedom.joint;
    while (const auto gear = GearOf(scene, *at)) {
      freedom.offset += freedom.ratio * gear->offset;
      freedom.ratio *= gear->ratio;
      at = gear->with;
    }
    if (at != freedom.joint) freedom.driver = numbers.at(at);
  }
  LimitDrivers(freedoms);
  return freedoms;
}

void Follow(std::span<const Freedom> freedoms, std::span<double> positions) {
  for (std::size_t i = 0; i < freedoms.size(); ++i)
    if (freedoms[i].driver)
      positions[i] = freedoms[i].ratio * positions[*freedoms[i].driver] + freedoms[i].offset;
}

std::optional<ConfigurationFault> FindConfigurationFault(const plan::Scene& scene) {
  for (const std::string& name : scene.world.Words("configurations.of"))
    if (name != "all" &&
        std::ranges::find(scene.joints, name, &plan::Joint::name) == scene.joints.end())
      return ConfigurationFault{"", schema::WorldParameter("configurations.of").get(),
                                fmt::format("there is no joint '{}'", name),
                                "name joints of the scene, or all"};
  for (const plan::Joint& joint : scene.joints)
    if (scene.world.Lists("configurations.of", joint.name) && GearOf(scene, joint))
      return ConfigurationFault{
          "", schema::WorldParameter("configurations.of").get(),
          fmt::format("{} follows {}, and has no position of its own", TextOf(joint),
                      joint.settings.WordOr("joints.gear.with")),
          fmt::format("name {}", LastDriverOf(scene, joint).name)};
  if (Refused fault = FindTreeFault(scene)) return fault;
  if (Refused fault = FindAskFault(scene)) return fault;
  const std::vector<Freedom> freedoms = FreedomsOf(scene);
  if (freedoms.empty())
    return ConfigurationFault{"", kPositions.get(), "there is no joint with a position",
                              "write joints of the type hinge or slider, or a robot"};
  for (const Freedom& freedom : freedoms)
    if (Refused fault = FindPositionFault(scene, freedom)) return fault;
  const bool is_path = scene.world.WordOr(kPositions) == "path";
  if (is_path && std::ranges::all_of(freedoms, [](const Freedom& freedom) {
        return freedom.driver || freedom.goal == freedom.start;
      }))
    return ConfigurationFault{"", kPositions.get(), "the path ends where it begins",
                              "give a joint another goal: elbow.goal 1 rad"};
  return std::nullopt;
}

const std::string& FileOfList(const schema::Call& list) {
  return std::get<schema::Text>(schema::ArgumentOf(list, "file")).text;
}

ConfigurationList ReadConfigurationList(const schema::Call& list, const std::string& text,
                                        const std::vector<Freedom>& freedoms) {
  const std::string& file = FileOfList(list);
  plan::TextTable table(text, file, plan::DialectOf(list));
  std::vector<plan::Column> columns;  // of the freedoms that follow none
  for (const Freedom& freedom : freedoms) {
    if (freedom.driver) continue;
    columns.push_back(table.Find(freedom.joint->name));
    const text::Unit unit = freedom.is_slider ? text::Unit{.length = 1} : text::Unit{.angle = 1};
    const auto& given = columns.back().unit;
    if (given && !given->HasDimensionOf(unit))
      throw plan::TableError(
          fmt::format("{}: the unit of {} is not one of {}", table.PlaceOfHeadings(),
                      columns.back().name, freedom.is_slider ? "a length" : "an angle"),
          freedom.is_slider ? "such as [m]" : "such as [rad] or [deg]");
  }
  table.FindDecimal(columns);
  if (table.rows() == 0)
    throw plan::TableError(fmt::format("{} has no line of numbers", file),
                           "write a line for each configuration");
  ConfigurationList read = {plan::Sha256Hex(text), {}, table.rows()};
  std::vector<double> positions(freedoms.size());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    auto column = columns.begin();
    for (std::size_t i = 0; i < freedoms.size(); ++i)
      if (!freedoms[i].driver) positions[i] = table.Number(row, *column++);
    Follow(freedoms, positions);
    read.positions.insert(read.positions.end(), positions.begin(), positions.end());
  }
  return read;
}

}  // namespace cdb::analysis
