#include "compiler/analysis/pruning.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "compiler/analysis/expectation.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/queries.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/series.h"
#include "dsl/text/check.h"

namespace cdb::analysis {
namespace {

using schema::Component;
using schema::ComponentInfo;
using schema::Components;
using schema::InfoOf;

bool IsConstantZero(const schema::Value& value) {
  if (const schema::Number* number = schema::AsNumber(value)) return number->AsReal() == 0;
  const auto* vector = std::get_if<Eigen::Vector3d>(&value);
  return vector != nullptr && vector->isZero(0);
}

/// The first group, by name, whose `parameter` is not the constant 0 or off.
std::optional<std::string> GroupWith(const plan::Scene& scene, schema::GroupParameter parameter) {
  for (const plan::Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0) continue;
    const schema::Value& value = group.settings.Get(parameter);
    const auto* on = std::get_if<bool>(&value);
    if (on != nullptr ? *on : !IsConstantZero(value)) return group.name;
  }
  return std::nullopt;
}

struct Answer {
  Decision decision;
  std::string why;
};

class Analysis {
 public:
  explicit Analysis(const plan::Scene& scene)
      : scene_(scene), ccd_(GroupWith(scene, "ccd")), spin_(GroupWith(scene, "angular_velocity")) {
    const auto told = std::ranges::find_if(scene.groups, [](const plan::Group& group) {
      return PosesOf(group) != nullptr && group.settings.Count("quantity") > 0;
    });
    if (told != scene.groups.end()) told_ = told->name;
    if (const std::string pulled = scene.PulledGroup(); !pulled.empty())
      pull_ = fmt::format("{} are linked and pull on one another", pulled);
    for (const plan::Group& group : scene.groups)
      if (!pull_ && HasPush(group))
        pull_ = fmt::format("a force or a torque acts on {}", group.name);
    if (const plan::Group* group = FindChanging(scene); !pull_ && group != nullptr)
      pull_ = fmt::format("{} come and go", group->name);
  }

  Answer Of(Component component, PruningRequest asked) const {
    if (HasSoft(scene_)) return {Decision::kKept, "the world of soft bodies omits nothing"};
    switch (component) {
      case Component::kWalls:
        return Walls();
      case Component::kRaycastTree:
        return RaycastTree();
      case Component::kDetection:
        return Detection(asked);
      case Component::kSolver:
        return IfNothingTouches();
      case Component::kSleeping:
        return Sleeping();
      case Component::kSweptContacts:
        if (ccd_) return {Decision::kKept, Sweeps()};
        return {Decision::kLeftOut, "no object has ccd"};
      case Component::kGravity:
        return Gravity();
      case Component::kDamping:
        return Damping();
      case Component::kRotation:
        return Rotation();
      case Component::kMotionStates:
        return {Decision::kLeftOut, "the scene is not drawn while it runs"};
      case Component::kStaticBoxes:
        return StaticBoxes();
      case Component::kPools:
        return {Decision::kOpen,
                "the possible number of contacts is known once all objects are placed"};
      case Component::kWallPairs:
        return WallPairs();
    }
    CDB_CHECK(false);
  }

 private:
  bool DetectorIsSweepAndPrune() const {
    return scene_.world.WordOr("detector").starts_with("sap");
  }

  std::string Sweeps() const { return fmt::format("{} have ccd and look ahead", *ccd_); }

  Answer Walls() const {
    if (scene_.world.WordOr("world.walls") == "none") return {Decision::kAbsent, "none stand"};
    if (HasQueries(scene_)) return {Decision::kKept, "queries may find them"};
    if (ccd_) return {Decision::kKept, Sweeps()};
    if (pull_) return {Decision::kKept, *pull_};
    return {Decision::kOpen, "the reach of each object is known once all objects are placed"};
  }

  // A pair without a contact has no effect if contacts are solved in the order of their bodies.
  Answer WallPairs() const {
    if (scene_.world.WordOr("world.walls") == "none") return {Decision::kAbsent, "none stand"};
    if (scene_.world.WordOr("world.wall_shape") != "plane")
      return {Decision::kAbsent,
              "walls are boxes, and only objects that reach them are in pairs with them"};
    if (scene_.world.WordOr("pair_order") != "sorted")
      return {Decision::kKept,
              "with pair_order listed, contacts are solved in an order that depends on all pairs; "
              "use pair_order sorted"};
    if (ccd_) return {Decision::kKept, Sweeps()};
    return {Decision::kOpen,
            "the number of pieces of each object is known once all objects are placed"};
  }

  Answer RaycastTree() const {
    if (!DetectorIsSweepAndPrune())
      return {Decision::kAbsent, fmt::format("{} has none", scene_.world.WordOr("detector"))};
    if (ccd_) return {Decision::kKept, Sweeps()};
    if (const plan::Queries* asked = FindBulletQueries(scene_))
      return {Decision::kKept, fmt::format("{} use it", TextOf(*asked))};
    return {Decision::kLeftOut, "no object has ccd, so nothing casts a ray"};
  }

  Answer Detection(PruningRequest asked) const {
    if (const plan::Queries* answered = FindBulletQueries(scene_))
      return {Decision::kKept, fmt::format("Bullet answers {} from the boxes of the broad phase",
                                           TextOf(*answered))};
    if (asked == PruningRequest::kByName) return IfNothingTouches();
    for (const schema::RecordWord& word : schema::kRecordWords)
      if (word.needs_detection && scene_.world.Lists("record", word.name))
        return {Decision::kKept, fmt::format("record {} asks for it", word.name)};
    for (const char* what : {"contacts", "pairs", "penetration"})
      if (scene_.world.Lists("accuracy.metrics", what))
        return {Decision::kKept, fmt::format("accuracy.metrics {} asks for it", what)};
    return IfNothingTouches();
  }

  Answer Sleeping() const {
    if (!scene_.world.On("sleeping")) return {Decision::kAbsent, "sleeping is off"};
    if (pull_) return {Decision::kKept, *pull_};
    return {Decision::kOpen,
            "whether an object can come to rest is known once all objects are placed"};
  }

  Answer Gravity() const {
    const schema::Value& acceleration = scene_.world.Get("acceleration");
    if (IsConstantZero(acceleration)) return {Decision::kLeftOut, "the acceleration is 0"};
    return {Decision::kKept, fmt::format("the acceleration is {}", schema::ToText(acceleration))};
  }

  Answer Damping() const {
    for (const auto what :
         {schema::GroupParameter("linear_damping"), schema::GroupParameter("angular_damping")})
      if (const auto group = GroupWith(scene_, what))
        return {Decision::kKept, fmt::format("{} have {}", *group, what.name())};
    return {Decision::kLeftOut, "no object is damped"};
  }

  Answer Rotation() const {
    if (spin_) return {Decision::kKept, fmt::format("{} have angular_velocity", *spin_)};
    if (told_)
      return {Decision::kKept, fmt::format("{} may have the angular velocities of a file", *told_)};
    if (pull_) return {Decision::kKept, *pull_};
    return {Decision::kOpen,
            "whether a contact can make an object spin is known once all objects are placed"};
  }

  Answer StaticBoxes() const {
    if (const plan::Group* group = FindChanging(scene_))
      return {Decision::kKept, fmt::format("{} come and go", group->name)};
    // A box that is not updated moves into the second tree of dbvt, without its margin, and pairs
    // are found in another order.
    if (scene_.world.WordOr("detector") == "dbvt")
      return {Decision::kKept, "dbvt finds other pairs where boxes are not updated"};
    if (scene_.world.On("sleeping"))
      return {Decision::kOpen,
              "an object that falls asleep needs its box once more; whether one can is known once "
              "all objects are placed"};
    return {Decision::kLeftOut, "walls and fixed objects do not move"};
  }

  Answer IfNothingTouches() const {
    if (ccd_) return {Decision::kKept, Sweeps()};
    if (pull_) return {Decision::kKept, *pull_};
    return {Decision::kOpen, "whether anything can touch is known once all objects are placed"};
  }

  const plan::Scene& scene_;
  std::optional<std::string> ccd_, spin_;  ///< a group with this property
  std::optional<std::string> pull_;        ///< that links or forces move objects, and which
  std::optional<std::string> told_;        ///< a group whose poses are read from a file
};

}  // namespace

PruningRequest RequestFor(const plan::Scene& scene, Component component) {
  const ComponentInfo& info = InfoOf(component);
  if (scene.world.Lists("omit", info.name)) return PruningRequest::kByName;
  const bool is_auto = info.is_in_auto && scene.world.Lists("omit", "auto");
  return is_auto ? PruningRequest::kAuto : PruningRequest::kNo;
}

std::vector<PruningDecision> AnalysePruning(const plan::Scene& scene) {
  const Analysis analysis(scene);
  const bool is_none = scene.world.Lists("omit", "none");
  const bool is_auto = scene.world.Lists("omit", "auto");
  std::vector<PruningDecision> decisions;
  decisions.reserve(Components().size());
  for (const ComponentInfo& info : Components()) {
    const PruningRequest asked = RequestFor(scene, info.component);
    Answer answer = asked == PruningRequest::kNo
                        ? Answer{Decision::kKept, is_none   ? "omit none"
                                                  : is_auto ? "omitted only if omit names it"
                                                            : "omit does not list it"}
                        : analysis.Of(info.component, asked);
    decisions.push_back({info.component, answer.decision, std::move(answer.why)});
  }
  return decisions;
}

std::string DecisionsText(std::span<const PruningDecision> decisions) {
  std::string text;
  for (const PruningDecision& part : decisions) {
    const char* word = part.decision == Decision::kLeftOut ? "left out"
                       : part.decision == Decision::kKept  ? "kept"
                       : part.decision == Decision::kOpen  ? "open"
                                                           : "none";
    text += fmt::format("{}: {}: {}\n", InfoOf(part.component).name, word, part.why);
  }
  return text;
}

bool SaysKept(std::string_view decisions_text, schema::Component component) {
  const std::string line = fmt::format("{}: kept: ", InfoOf(component).name);
  for (std::size_t at = decisions_text.find(line); at != decisions_text.npos;
       at = decisions_text.find(line, at + 1))
    if (at == 0 || decisions_text[at - 1] == '\n') return true;
  return false;
}

std::string OmittedNames(std::span<const PruningDecision> decisions) {
  std::string names;
  for (const PruningDecision& part : decisions)
    if (part.decision == Decision::kLeftOut)
      names += (names.empty() ? "" : " ") + std::string(InfoOf(part.component).name);
  return names;
}

}  // namespace cdb::analysis
