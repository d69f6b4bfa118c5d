#include "compiler/needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "dsl/check.h"

namespace cdb::compiler {
namespace {

// clang-format off
constexpr ComponentInfo kComponents[] = {
    {Component::kWalls, "walls",
     "a wall for the objects that cannot reach it, and the whole wall where none can",
     "pairs and the broad phase are without them"},
    {Component::kRaycastTree, "raycast_tree",
     "the tree for ray casts that Bullet keeps beside sap and sap32",
     "the broad phase keeps no second tree"},
    {Component::kDetection, "detection",
     "broad and narrow phase, where nothing can touch and no record asks for them",
     "nothing is detected"},
    {Component::kSolver, "solver",
     "islands and constraint solver, where nothing can touch",
     "solve is forces becoming velocity, and nothing else"},
    {Component::kSleeping, "sleeping",
     "the watch for objects at rest, where none can come to rest",
     "step is without it"},
    {Component::kSweptContacts, "swept_contacts",
     "the pass that looks for contacts on the way of ccd objects", ""},
    {Component::kGravity, "gravity",
     "the pass that applies gravity", ""},
    {Component::kDamping, "damping",
     "two powers an object and cycle that slow it", ""},
    {Component::kRotation, "rotation",
     "turning objects that never spin", ""},
    {Component::kMotionStates, "motion_states",
     "the pass that would hand poses to a renderer", ""},
    {Component::kStaticBoxes, "static_boxes",
     "boxes of walls and fixed objects, worked out anew each cycle", ""},
    {Component::kPools, "pools",
     "memory set aside for more contacts than the scene can have", ""},
};
// clang-format on

constexpr std::size_t kCount = std::size(kComponents);

bool IsConstantZero(const Value& value) {
  if (const auto* real = std::get_if<double>(&value)) return *real == 0;
  const auto* vector = std::get_if<Eigen::Vector3d>(&value);
  return vector != nullptr && vector->isZero(0);
}

/// The first group, by its name, whose `parameter` is not the constant 0 or off.
std::optional<std::string> GroupWith(const Scene& scene, std::string_view parameter) {
  for (const Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0) continue;
    const Value& value = group.settings.Get(parameter);
    const auto* on = std::get_if<bool>(&value);
    if (on != nullptr ? *on : !IsConstantZero(value)) return group.name;
  }
  return std::nullopt;
}

struct Answer {
  Fate fate;
  std::string why;
};

class Analysis {
 public:
  explicit Analysis(const Scene& scene)
      : scene_(scene), ccd_(GroupWith(scene, "ccd")), spin_(GroupWith(scene, "angular_velocity")) {
    const auto linked = std::ranges::find_if(scene.groups, &Group::HasLinks);
    if (linked != scene.groups.end()) linked_ = linked->name;
  }

  Answer Of(Component component, Asked asked) const {
    switch (component) {
      case Component::kWalls:
        if (scene_.world.WordOr("world.walls") == "none") return {Fate::kAbsent, "none stand"};
        if (ccd_) return {Fate::kKept, Sweeps()};
        if (linked_) return {Fate::kKept, Pull()};
        return {Fate::kOpen, "where each object can get to is known when all are placed"};
      case Component::kRaycastTree:
        if (!DetectorIsSweepAndPrune())
          return {Fate::kAbsent, fmt::format("{} has none", scene_.world.WordOr("detector"))};
        if (ccd_) return {Fate::kKept, Sweeps()};
        return {Fate::kLeftOut, "no object has ccd, so nothing casts a ray"};
      case Component::kDetection:
        if (asked != Asked::kByName)
          for (const char* what : {"timing", "counts", "contacts", "pairs", "boxes"})
            if (scene_.world.Lists("record", what))
              return {Fate::kKept, fmt::format("record {} asks for it", what)};
        if (asked != Asked::kByName)
          for (const char* what : {"contacts", "pairs", "penetration"})
            if (scene_.world.Lists("accuracy.metrics", what))
              return {Fate::kKept, fmt::format("accuracy.metrics {} asks for it", what)};
        return IfNothingTouches();
      case Component::kSolver:
        return IfNothingTouches();
      case Component::kSleeping:
        if (!scene_.world.On("sleeping")) return {Fate::kAbsent, "sleeping is off"};
        if (linked_) return {Fate::kKept, Pull()};
        return {Fate::kOpen, "whether an object can come to rest is known when all are placed"};
      case Component::kSweptContacts:
        if (ccd_) return {Fate::kKept, Sweeps()};
        return {Fate::kLeftOut, "no object has ccd"};
      case Component::kGravity:
        if (IsConstantZero(scene_.world.Get("acceleration")))
          return {Fate::kLeftOut, "the acceleration is 0"};
        return {Fate::kKept,
                fmt::format("the acceleration is {}", ToText(scene_.world.Get("acceleration")))};
      case Component::kDamping:
        for (const char* what : {"linear_damping", "angular_damping"})
          if (const auto group = GroupWith(scene_, what))
            return {Fate::kKept, fmt::format("{} have {}", *group, what)};
        return {Fate::kLeftOut, "no object is damped"};
      case Component::kRotation:
        if (spin_) return {Fate::kKept, fmt::format("{} have angular_velocity", *spin_)};
        if (linked_) return {Fate::kKept, Pull()};
        return {Fate::kOpen,
                "whether a touch can set an object spinning is known when all are "
                "placed"};
      case Component::kMotionStates:
        return {Fate::kLeftOut, "nothing draws the scene while it runs"};
      case Component::kStaticBoxes:
        // A box that is not updated moves into dbvt's second tree, without its margin, and pairs
        // are found in another order.
        if (scene_.world.WordOr("detector") == "dbvt")
          return {Fate::kKept, "dbvt finds other pairs where boxes are not updated"};
        if (scene_.world.On("sleeping"))
          return {Fate::kOpen,
                  "an object that falls asleep needs its box once more; whether one can is known "
                  "when all are placed"};
        return {Fate::kLeftOut, "walls and fixed objects stay where they are"};
      case Component::kPools:
        return {Fate::kOpen, "how many contacts there can be is known when all are placed"};
    }
    CDB_CHECK(false);
  }

 private:
  bool DetectorIsSweepAndPrune() const {
    return scene_.world.WordOr("detector").starts_with("sap");
  }

  std::string Sweeps() const { return fmt::format("{} have ccd and look ahead", *ccd_); }
  std::string Pull() const {
    return fmt::format("{} are linked and pull at one another", *linked_);
  }

  Answer IfNothingTouches() const {
    if (ccd_) return {Fate::kKept, Sweeps()};
    if (linked_) return {Fate::kKept, Pull()};
    return {Fate::kOpen, "whether anything can touch is known when all are placed"};
  }

  const Scene& scene_;
  std::optional<std::string> ccd_, spin_, linked_;  ///< a group that has it
};

}  // namespace

std::span<const ComponentInfo> Components() { return kComponents; }

const ComponentInfo& InfoOf(Component component) {
  const ComponentInfo& info = kComponents[static_cast<std::size_t>(component)];
  CDB_CHECK(info.component == component);
  return info;
}

const ComponentInfo* FindComponent(std::string_view name) {
  const auto* row = std::ranges::find(kComponents, name, &ComponentInfo::name);
  return row == std::end(kComponents) ? nullptr : row;
}

Asked HowAsked(const Scene& scene, Component component) {
  if (scene.world.Lists("omit", "auto")) return Asked::kAuto;
  return scene.world.Lists("omit", InfoOf(component).name) ? Asked::kByName : Asked::kNo;
}

std::vector<Need> AnalyseNeeds(const Scene& scene) {
  const Analysis analysis(scene);
  const bool is_none = scene.world.Lists("omit", "none");
  std::vector<Need> needs;
  needs.reserve(kCount);
  for (const ComponentInfo& info : kComponents) {
    const Asked asked = HowAsked(scene, info.component);
    Answer answer = asked == Asked::kNo
                        ? Answer{Fate::kKept, is_none ? "omit none" : "omit does not list it"}
                        : analysis.Of(info.component, asked);
    needs.push_back({info.component, answer.fate, std::move(answer.why)});
  }
  return needs;
}

std::string NeedsText(std::span<const Need> needs) {
  std::string text;
  for (const Need& need : needs) {
    const char* fate = need.fate == Fate::kLeftOut ? "left out"
                       : need.fate == Fate::kKept  ? "kept"
                       : need.fate == Fate::kOpen  ? "open"
                                                   : "none";
    text += fmt::format("{}: {}: {}\n", InfoOf(need.component).name, fate, need.why);
  }
  return text;
}

std::string OmittedNames(std::span<const Need> needs) {
  std::string names;
  for (const Need& need : needs)
    if (need.fate == Fate::kLeftOut)
      names += (names.empty() ? "" : " ") + std::string(InfoOf(need.component).name);
  return names;
}

}  // namespace cdb::compiler
