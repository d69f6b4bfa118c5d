#include "compiler/analysis/coverage.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/joints.h"
#include "compiler/analysis/population.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::analysis {
namespace {

using plan::Group;
using plan::Scene;
using schema::IsZero;
using Reason = std::optional<std::string>;

/// The first group with objects for which it holds; null if there is none.
const Group* FindGroup(const Scene& scene, auto holds) {
  const auto found = std::ranges::find_if(scene.groups, [&](const Group& group) {
    return group.settings.Count("quantity") > 0 && holds(group);
  });
  return found == scene.groups.end() ? nullptr : &*found;
}

bool IsFixed(const Group& group) { return group.settings.WordOr("mass") == "fixed"; }

bool Spins(const Group& group) {
  return !IsFixed(group) && !IsZero(group.settings.Get("angular_velocity"));
}

bool CanMove(const Scene& scene) {
  return FindGroup(scene, [](const Group& group) { return !IsFixed(group); }) != nullptr;
}

bool Always(const Scene&) { return true; }
Reason AlwaysChecked(const Scene&) { return std::nullopt; }

Reason WhyNotEnergy(const Scene& scene) {
  const std::string driver = DriverText(scene);
  return driver.empty() ? Reason() : driver;
}

bool IsDamped(const Group& group) {
  return !IsZero(group.settings.Get("linear_damping")) ||
         !IsZero(group.settings.Get("angular_damping"));
}

bool HasRollingFriction(const Group& group) {
  return !IsZero(group.settings.Get("rolling_friction"));
}

bool HasSpinningFriction(const Group& group) {
  return !IsZero(group.settings.Get("spinning_friction"));
}

bool HasSoftContacts(const Group& group) {
  return group.settings.WordOr("contact_stiffness") != "rigid";
}

bool HasSprings(const Group& group) {
  return group.HasLinks() && group.settings.WordOr("links.type") == "spring";
}

Reason WhyNotLosses(const Scene& scene) {
  if (Reason driven = WhyNotEnergy(scene)) return driven;
  if (scene.world.WordOr("expect") == "anything") return "the scene says expect anything";
  struct Sink {
    const char* text;
    bool (*is_in)(const Group& group);
  };
  static constexpr Sink kSinks[] = {
      {"damping", IsDamped},
      {"springs with damping",
       [](const Group& group) {
         return HasSprings(group) && !IsZero(group.settings.Get("links.damping"));
       }},
      {"rolling friction", HasRollingFriction},
      {"spinning friction", HasSpinningFriction},
      {"soft contacts", HasSoftContacts},
  };
  for (const Sink& sink : kSinks)
    if (const Group* group = FindGroup(scene, sink.is_in))
      return fmt::format("group {} has {}", group->name, sink.text);
  if (const plan::Joint* joint = FindLosses(scene))
    return fmt::format("{} has {}", TextOf(*joint),
                       HasLimits(*joint)                            ? "limits"
                       : joint->settings.Real("joints.damping") > 0 ? "damping"
                                                                    : "friction");
  return std::nullopt;
}

/// Something in the scene stands, or the user says that it does.
bool RestArises(const Scene& scene) {
  return scene.world.WordOr("expect") == "rest" || FindGroup(scene, Stands) != nullptr;
}

bool MayBeMesh(const schema::Value& type) {
  if (const schema::Call* call = schema::AsCall(type)) return !IsSurface(*call);
  const schema::Distribution* drawn = schema::AsDistribution(type);
  return drawn != nullptr && std::ranges::any_of(drawn->arguments, MayBeMesh);
}

/// Its faces may continue one another.
bool MayAdjoin(const Group& group) {
  return group.settings.WordOr("type") != "sphere" &&
         (group.settings.Count("quantity") > 1 || MayBeMesh(group.settings.Get("type")));
}

bool MovesAsGround(const Group& group) { return HasKinematic(group) && MayAdjoin(group); }

bool EdgesArise(const Scene& scene) {
  return FindGroup(scene, [](const Group& group) {
           return HasSurface(group.settings) || MovesAsGround(group) ||
                  (IsFixed(group) && MayAdjoin(group));
         }) != nullptr;
}

Reason WhyNotEdges(const Scene& scene) {
  if (const Group* group = FindGroup(scene, MovesAsGround))
    return fmt::format("group {} is kinematic, and only fixed ground is examined", group->name);
  // Each surface is examined by itself, and walls are not.
  const Group* surface =
      FindGroup(scene, [](const Group& group) { return HasSurface(group.settings); });
  if (surface != nullptr) {
    if (surface->settings.Count("quantity") > 1)
      return fmt::format("seams between surfaces of group {} are not examined", surface->name);
    const Group* other =
        FindGroup(scene, [&](const Group& group) { return &group != surface && IsFixed(group); });
    if (other != nullptr)
      return fmt::format("seams between groups {} and {} are not examined", surface->name,
                         other->name);
  }
  const Group* beyond = FindGroup(
      scene, [](const Group& group) { return IsFixed(group) && group.settings.On("overlap"); });
  if (beyond == nullptr || scene.world.WordOr("world.walls") == "none") return std::nullopt;
  return fmt::format("seams between group {} and the walls are not examined", beyond->name);
}

/// Something may slide or roll on ground.
bool FrictionArises(const Scene& scene) {
  const bool has_walls = scene.world.WordOr("world.walls") != "none" &&
                         !IsZero(scene.world.Get("world.wall_friction"));
  const auto has_friction = [](const Group& group) {
    return !IsZero(group.settings.Get("friction"));
  };
  const auto is_ground = [&](const Group& group) {
    return (IsFixed(group) || HasKinematic(group)) && has_friction(group);
  };
  return (has_walls || FindGroup(scene, is_ground) != nullptr) &&
         FindGroup(scene, [&](const Group& group) {
           return !IsFixed(group) && !HasKinematic(group) && has_friction(group) &&
                  group.settings.WordOr("type") != "sphere";
         }) != nullptr;
}

Reason WhyNotFriction(const Scene& scene) {
  const Group* surface =
      FindGroup(scene, [](const Group& group) { return HasSurface(group.settings); });
  if (surface != nullptr)
    return fmt::format("sliding on surfaces, such as group {}, is not examined", surface->name);
  if (const Group* moving = FindGroup(scene, HasKinematic))
    return fmt::format("sliding on moving ground, such as group {}, is not examined", moving->name);
  if (const Group* pushed = FindGroup(scene, HasPush))
    return fmt::format(
        "sliding of objects with a force or a torque, as of group {}, is not "
        "examined",
        pushed->name);
  const auto spins = [](const Group& group) {
    return Spins(group) && group.settings.WordOr("type") != "sphere";
  };
  if (const Group* group = FindGroup(scene, spins))
    return fmt::format("group {} spins, and how objects turn on a face or a rim is not examined",
                       group->name);
  if (const std::string held = scene.PulledGroup(); !held.empty())
    return fmt::format("sliding of objects with links or joints, as of group {}, is not examined",
                       held);
  if (const Group* group = FindGroup(scene, [](const Group& one) {
        return !IsFixed(one) && MayBe(one.settings.Get("type"), schema::kSuperellipsoidType);
      }))
    return fmt::format("rolling of superellipsoids, as of group {}, is not examined", group->name);
  const auto rolls = [](const Group& group) {
    return !IsFixed(group) && MayRoll(group.settings.Get("type"));
  };
  const auto resists = [&](const Group& group) {
    return rolls(group) && (IsDamped(group) || HasRollingFriction(group));
  };
  if (const Group* group = FindGroup(scene, resists))
    return fmt::format("rolling with {}, as of group {}, is not examined",
                       IsDamped(*group) ? "damping" : "rolling friction", group->name);
  const Group* roller = FindGroup(scene, rolls);
  if (roller == nullptr) return std::nullopt;
  if (const Group* other = FindGroup(scene, [](const Group& group) {
        return IsFixed(group) && group.settings.WordOr("type") != "cuboid";
      }))
    return fmt::format("rolling on group {}, which is not of cuboids, is not examined",
                       other->name);
  if (const Group* slab = FindGroup(scene, [&](const Group& group) {
        return !IsFixed(group) && MayBe(group.settings.Get("type"), "cuboid") &&
               (&group != roller || group.settings.Count("quantity") > 1);
      }))
    return fmt::format(
        "rolling on objects that can move, such as those of group {}, is not examined", slab->name);
  return std::nullopt;
}

Reason WhyNotImpacts(const Scene& scene) {
  if (const Group* surface =
          FindGroup(scene, [](const Group& group) { return HasSurface(group.settings); }))
    return fmt::format("impacts on surfaces, such as group {}, are not examined", surface->name);
  if (const Group* soft = FindGroup(scene, HasSoftContacts))
    return fmt::format("group {} has soft contacts", soft->name);
  if (const Group* driven = FindGroup(
          scene, [](const Group& group) { return HasSchedule(group) && !HasKinematic(group); }))
    return fmt::format("a schedule moves group {}", driven->name);
  if (const Group* pushed = FindGroup(scene, HasPush))
    return fmt::format(
        "impacts of objects with a force or a torque, as of group {}, are not "
        "examined",
        pushed->name);
  // The rest is examined in part.
  if (const std::string held = scene.PulledGroup(); !held.empty())
    return fmt::format(
        "only the direction is examined of objects with links or joints, as of group {}", held);
  if (const Group* rolls = FindGroup(scene, [](const Group& group) {
        return HasRollingFriction(group) || HasSpinningFriction(group);
      }))
    return fmt::format(
        "only the direction is examined with rolling or spinning friction, as of group {}",
        rolls->name);
  if (const Group* mesh = FindGroup(
          scene, [](const Group& group) { return MayBeMesh(group.settings.Get("type")); }))
    return fmt::format("only the direction is examined of meshes, as in group {}", mesh->name);
  return std::nullopt;
}

bool SpringsArise(const Scene& scene) { return FindGroup(scene, HasSprings) != nullptr; }

Reason WhyNotSprings(const Scene& scene) {
  return fmt::format("the motion of group {} is not compared with the stiffness of its springs",
                     FindGroup(scene, HasSprings)->name);
}

/// Springs may stretch.
bool JointsArise(const Scene& scene) {
  return std::ranges::any_of(scene.joints,
                             [&](const plan::Joint& joint) { return scene.HoldsObjects(joint); }) ||
         FindGroup(scene, [](const Group& group) {
           return group.HasLinks() && !HasSprings(group);
         }) != nullptr;
}

/// A gyroscope sinks, with errors that fall with the time step.
Reason WhyNotJoints(const Scene& scene) {
  const Group* spins = FindGroup(scene, [](const Group& group) {
    return Spins(group) && group.HasLinks() && group.settings.WordOr("links.type") == "ball";
  });
  for (const plan::Joint& joint : scene.joints) {
    if (joint.settings.WordOr("joints.type") != "ball" || !scene.HoldsObjects(joint)) continue;
    for (const std::string_view side :
         {joint.settings.WordOr("joints.parent"), joint.settings.WordOr("joints.child")}) {
      const Group* group = scene.FindGroup(side);
      if (group != nullptr && Spins(*group)) spins = group;
    }
  }
  if (spins == nullptr) return std::nullopt;
  return fmt::format("group {} spins on a ball joint, and its angular momentum is not examined",
                     spins->name);
}

Reason WhyNotSleep(const Scene& scene) {
  const std::string group = scene.PulledGroup();
  if (group.empty()) return std::nullopt;
  return fmt::format("{} may hold the objects of group {}, and their forces are not judged",
                     scene.FindGroup(group)->HasLinks() ? "links" : "joints", group);
}

bool MaySleep(const Scene& scene) { return scene.world.On("sleeping") && !HasSoft(scene); }

/// Of soft bodies, and of rigid ones beside them.
Reason WhyNotOfSoft(Question question, const Scene& scene) {
  switch (question) {
    case Question::kEnergy:
      return "the solver of soft bodies takes energy, so that only a rise is judged";
    case Question::kLosses:
      return "the solver of soft bodies takes energy";
    case Question::kPassing:
      return "of soft bodies, only nodes in a rigid one at the end of a cycle, and faces that move "
             "over its centre, are found; two rigid bodies beside them are not followed";
    case Question::kStretch:
      return scene.world.WordOr("soft_world") == "springs"
                 ? Reason(
                       "the springs and materials of soft bodies stretch, and are not compared "
                       "with their stiffness")
                 : Reason();
    default:
      return "it is not examined of soft bodies, nor of what moves beside them";
  }
}

/// Series that follow an object from cycle to cycle are not recorded.
Reason WhyNotOfChanging(Question question, const Scene& scene) {
  if (question == Question::kPassing)
    return "of objects that come and go, only those beyond a wall at the end of a cycle are found";
  return fmt::format("it is not examined where objects come and go, as those of group {}",
                     FindChanging(scene)->name);
}

constexpr QuestionInfo kQuestions[] = {
    {Question::kEnergy, "energy",
     "the total energy does not rise, and is kept until something touches", true, Always,
     WhyNotEnergy},
    {Question::kLosses, "losses",
     "no energy is lost beyond the work of friction and of inelastic bounces", false, Always,
     WhyNotLosses},
    {Question::kRest, "rest", "objects that stand stay where they are", true, RestArises,
     WhyNotAtRest},
    {Question::kPassing, "passing",
     "objects do not pass through others, or leave the walls, and are not pressed in", true, Always,
     AlwaysChecked},
    {Question::kEdges, "edges",
     "contacts at the edges between coplanar faces have the normals of these faces", false,
     EdgesArise, WhyNotEdges},
    {Question::kFriction, "friction",
     "friction brakes objects that slide flat on fixed ground as its coefficient says, and turns "
     "none of them; what rolls keeps its speed",
     false, FrictionArises, WhyNotFriction},
    {Question::kImpacts, "impacts", "impacts end as shapes, velocities and coefficients say", false,
     Always, WhyNotImpacts},
    {Question::kJoints, "joints",
     "joints do not open, bend or stretch, and motors reach what they seek where nothing touches"
     " their joints",
     true, JointsArise, WhyNotJoints},
    {Question::kSprings, "springs", "springs pull as their stiffness and damping say", false,
     SpringsArise, WhyNotSprings},
    {Question::kSleep, "sleep", "objects that fall asleep are held", true, MaySleep, WhyNotSleep},
    {Question::kStretch, "stretch",
     "the links of soft bodies that must keep their length (soft_world positions) stay shorter "
     "than 1.1 times it",
     false, HasSoft, AlwaysChecked},
};

const QuestionInfo& InfoOf(Question question) {
  return kQuestions[static_cast<std::size_t>(question)];
}

Reason WhyNot(const QuestionInfo& info, const Scene& scene) {
  if (HasSoft(scene)) return WhyNotOfSoft(info.question, scene);
  return ComesOrGoes(scene) ? WhyNotOfChanging(info.question, scene) : info.why_not(scene);
}

}  // namespace

bool MayRoll(const schema::Value& type) {
  return MayBe(type, "cylinder") || MayBe(type, "capsule");
}

std::span<const QuestionInfo> Questions() { return kQuestions; }

Coverage CoverageOf(const plan::Scene& scene) {
  Coverage coverage;
  if (!CanMove(scene) || HasConfigurations(scene)) return coverage;
  const bool is_recorded = scene.world.Lists("record", "stability");
  for (const QuestionInfo& info : kQuestions) {
    if (!info.arises(scene)) continue;
    Reason why = is_recorded ? WhyNot(info, scene) : Reason("record lacks stability");
    if (why) {
      coverage.unchecked.push_back({&info, *std::move(why)});
    } else {
      coverage.checked.push_back(&info);
    }
  }
  return coverage;
}

bool IsChecked(Question question, const plan::Scene& scene) {
  const QuestionInfo& info = InfoOf(question);
  return info.arises(scene) && !WhyNot(info, scene);
}

bool AreGainsJudged(const plan::Scene& scene) {
  return IsChecked(Question::kEnergy, scene) && FindGroup(scene, HasSoftContacts) == nullptr;
}

std::string CheckedText(const Coverage& coverage) {
  std::string text;
  for (const QuestionInfo* question : coverage.checked)
    text.append(text.empty() ? "" : ", ").append(question->name);
  return text;
}

std::string UncheckedText(const Coverage& coverage) {
  std::string text;
  for (const Coverage::Open& open : coverage.unchecked)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", open.question->name, open.why);
  return text;
}

}  // namespace cdb::analysis
