#include "compiler/analysis/joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/time_table.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::analysis {
namespace {

using Kind = JointFault::Kind;
using schema::GroupParameter;
using Fault = std::optional<JointFault>;

constexpr auto kParent = schema::ParameterRef<true, schema::ValueKind::kWord>("joints.parent");
constexpr auto kChild = schema::ParameterRef<true, schema::ValueKind::kWord>("joints.child");
constexpr auto kStart = schema::ParameterRef<true, schema::ValueKind::kReal>("joints.start");
constexpr auto kAxis = schema::ParameterRef<true, schema::ValueKind::kVector>("joints.axis");
constexpr auto kSecondAxis = schema::ParameterRef<true, schema::ValueKind::kVector>("joints.axis2");
constexpr auto kType = schema::ParameterRef<true, schema::ValueKind::kWord>("joints.type");
constexpr auto kGearWith = schema::ParameterRef<true, schema::ValueKind::kWord>("joints.gear.with");
constexpr auto kGearRatio =
    schema::ParameterRef<true, schema::ValueKind::kReal>("joints.gear.ratio");
constexpr auto kGearOffset =
    schema::ParameterRef<true, schema::ValueKind::kReal>("joints.gear.offset");
constexpr auto kLower = schema::ParameterRef<true, schema::ValueKind::kReal>("joints.limits.lower");
constexpr auto kUpper = schema::ParameterRef<true, schema::ValueKind::kReal>("joints.limits.upper");

bool HasNumber(const plan::Joint& joint, GroupParameter parameter) {
  return schema::AsNumber(joint.settings.Get(parameter)) != nullptr;
}

/// A number, or a table of them over time.
bool HasGoal(const plan::Joint& joint, GroupParameter parameter) {
  return HasNumber(joint, parameter) || TimeTableOf(joint.settings.Get(parameter)) != nullptr;
}

const plan::Joint* FindJoint(const plan::Scene& scene, auto has) {
  const auto found = std::ranges::find_if(scene.joints, [&](const plan::Joint& joint) {
    return scene.HoldsObjects(joint) && has(joint);
  });
  return found == scene.joints.end() ? nullptr : &*found;
}

/// Whether one number says where the child is.
bool HasPosition(const plan::Joint& joint) {
  const std::string_view type = joint.settings.WordOr(kType);
  return type == "hinge" || type == "slider";
}

const plan::Joint* PartnerOf(const plan::Scene& scene, const plan::Joint& joint) {
  const auto found =
      std::ranges::find(scene.joints, joint.settings.WordOr(kGearWith), &plan::Joint::name);
  return found == scene.joints.end() ? nullptr : &*found;
}

/// Whether the gears from this joint on come back to one that they have passed.
bool EndsInCircle(const plan::Scene& scene, const plan::Joint& joint) {
  std::size_t steps = 0;
  for (const plan::Joint* at = &joint; at != nullptr; at = PartnerOf(scene, *at))
    if (steps++ > scene.joints.size()) return true;
  return false;
}

/// The sides of a joint that exist: null stands for the world.
struct Sides {
  std::string_view parent, child;
  const plan::Group *of_parent, *of_child;

  Sides(const plan::Scene& scene, const plan::Joint& joint)
      : parent(joint.settings.WordOr(kParent)),
        child(joint.settings.WordOr(kChild)),
        of_parent(scene.FindGroup(parent)),
        of_child(scene.FindGroup(child)) {}

  static std::uint64_t Count(const plan::Group* group) {
    return group == nullptr ? 1 : group->settings.Count("quantity");
  }
  /// Pairs of objects.
  std::uint64_t Count() const { return std::max(Count(of_parent), Count(of_child)); }
};

bool CannotMove(const plan::Group* group) {
  return group == nullptr || group->settings.WordOr("mass") == "fixed" ||
         group->settings.WordOr("mass") == kKinematicWord;
}

Fault FindSideFault(const plan::Scene& scene, const plan::Joint& joint) {
  const Sides sides(scene, joint);
  if (sides.child == "none")
    return JointFault{kChild, fmt::format("{} has no child", TextOf(joint)),
                      "name the group that it joins to the parent: child NAME"};
  if (sides.parent == sides.child)
    return JointFault{kChild, fmt::format("{} joins {} to itself", TextOf(joint), sides.child),
                      sides.child == plan::kWorldWord
                          ? "name a group of objects"
                          : "links { … } joins each object of a group to the next one"};
  if (sides.parent != plan::kWorldWord && sides.of_parent == nullptr)
    return JointFault{kParent, std::string(sides.parent), {}, Kind::kUnknownGroup};
  if (sides.child != plan::kWorldWord && sides.of_child == nullptr)
    return JointFault{kChild, std::string(sides.child), {}, Kind::kUnknownGroup};
  if (!scene.HoldsObjects(joint)) return std::nullopt;
  const std::uint64_t parents = Sides::Count(sides.of_parent),
                      children = Sides::Count(sides.of_child);
  if (parents != children && parents != 1 && children != 1)
    return JointFault{kChild,
                      fmt::format("{} joins {} objects of {} to {} of {}", TextOf(joint), parents,
                                  sides.parent, children, sides.child),
                      "give both groups the same quantity, or one of them a single object",
                      Kind::kQuantity};
  if (CannotMove(sides.of_parent) && CannotMove(sides.of_child))
    return JointFault{kChild,
                      fmt::format("nothing can move {} or {}, so {} has no effect", sides.parent,
                                  sides.child, TextOf(joint)),
                      "give one of them a mass"};
  for (const plan::Group* group : {sides.of_parent, sides.of_child}) {
    if (group == nullptr) continue;
    const schema::Call* layout = schema::AsCall(group->settings.Get("location"));
    if (layout != nullptr && layout->name == "pile")
      return JointFault{
          group == sides.of_parent ? kParent : kChild,
          fmt::format("the {} settle in a pile, which cannot have joints", group->name),
          "write another location"};
  }
  return std::nullopt;
}

/// A universal joint is a cross, whose axes are perpendicular.
Fault FindAxesFault(const plan::Joint& joint) {
  const Eigen::Vector3d first = joint.settings.Vector(kAxis).stableNormalized(),
                        second = joint.settings.Vector(kSecondAxis).stableNormalized();
  constexpr double kRounding = 1e-6;  // of the cosine
  if (std::abs(first.dot(second)) <= kRounding) return std::nullopt;
  const Eigen::Vector3d across = second - second.dot(first) * first;
  return JointFault{
      joint.settings.Has(*GroupParameter(kSecondAxis)) ? GroupParameter(kSecondAxis)
                                                       : GroupParameter(kAxis),
      fmt::format("the axes of {} are not perpendicular", TextOf(joint)),
      across.norm() > kRounding
          ? fmt::format("write axis2 ({}, {}, {})", schema::FormatReal(across.x()),
                        schema::FormatReal(across.y()), schema::FormatReal(across.z()))
          : "write an axis2 that is perpendicular to axis"};
}

/// What a joint of this type does not have.
Fault FindTypeFault(const plan::Joint& joint) {
  const std::string_view type = joint.settings.WordOr(kType);
  if (type == "universal") {
    if (Fault fault = FindAxesFault(joint)) return fault;
  } else if (joint.settings.Has(*GroupParameter(kSecondAxis))) {
    return JointFault{kSecondAxis,
                      fmt::format("{} has no second axis, as its type is {}", TextOf(joint), type),
                      "remove it, or write type universal"};
  }
  if (HasPosition(joint)) return std::nullopt;
  struct Part {
    GroupParameter parameter;
    const char* what;
  };
  constexpr std::array<Part, 16> kParts = {{{"joints.axis", "axis"},
                                            {"joints.start", "start"},
                                            {"joints.goal", "goal"},
                                            {"joints.limits.lower", "limits"},
                                            {"joints.limits.upper", "limits"},
                                            {"joints.gear.with", "gear"},
                                            {"joints.gear.ratio", "gear"},
                                            {"joints.gear.offset", "gear"},
                                            {"joints.damping", "damping"},
                                            {"joints.friction", "friction"},
                                            {"joints.motor.velocity", "motor"},
                                            {"joints.motor.position", "motor"},
                                            {"joints.motor.effort", "motor"},
                                            {"joints.motor.torque", "motor"},
                                            {"joints.motor.force", "motor"},
                                            {"joints.armature", "armature"}}};
  for (const Part& part : kParts)
    if (joint.settings.Has(*part.parameter) &&
        !(type == "universal" && part.parameter.get() == GroupParameter(kAxis).get()))
      return JointFault{
          part.parameter,
          fmt::format("{} has no {}, as its type is {}", TextOf(joint), part.what, type),
          "remove it, or write type hinge or type slider"};
  return std::nullopt;
}

/// Of positions that a gear computes.
constexpr double kGearRounding = 1e-9;
constexpr double kMostRatio = 1e9;

Fault FindLimitFault(const plan::Joint& joint) {
  const bool has_lower = HasNumber(joint, kLower), has_upper = HasNumber(joint, kUpper);
  if (!has_lower && !has_upper) return std::nullopt;
  if (has_lower != has_upper)
    return JointFault{has_lower ? kLower : kUpper,
                      fmt::format("{} has only one limit", TextOf(joint)),
                      "give both, lower and upper, or none"};
  const double lower = joint.settings.Real(kLower), upper = joint.settings.Real(kUpper);
  if (lower >= upper)
    return JointFault{
        kUpper,
        fmt::format("the upper limit of {}, {}, is not above the lower one, {}", TextOf(joint),
                    schema::FormatReal(upper), schema::FormatReal(lower)),
        lower == upper ? "write type fixed if it cannot move" : "exchange them"};
  const double start = joint.settings.Real(kStart);
  // A gear computes where its joint starts.
  const bool is_in_gear = joint.settings.WordOr(kGearWith) != "none";
  const double slack = is_in_gear ? kGearRounding * (1 + std::abs(start)) : 0;
  if (lower > start + slack || upper < start - slack)
    return JointFault{lower > start ? kLower : kUpper,
                      fmt::format("{} starts at {}, outside its limits", TextOf(joint),
                                  schema::FormatReal(start)),
                      start == 0 ? "limits are measured from the initial poses"
                                 : "`start` and limits are measured from the pose that the "
                                   "layout of the child gives it"};
  return std::nullopt;
}

/// The start turns or moves the child from where its layout places it.
Fault FindStartFault(const plan::Scene& scene, const plan::Joint& joint) {
  if (joint.settings.Real(kStart) == 0) return std::nullopt;
  const Sides sides(scene, joint);
  const schema::Call* layout = sides.of_child == nullptr
                                   ? nullptr
                                   : schema::AsCall(sides.of_child->settings.Get("location"));
  if (layout != nullptr && layout->name == schema::kRelativeCall &&
      std::get<schema::Word>(schema::ArgumentOf(*layout, "group")).text == sides.parent)
    return std::nullopt;
  return JointFault{kStart,
                    fmt::format("{} does not start at 0, but {} is not located relative to {}",
                                TextOf(joint), sides.child, sides.parent),
                    sides.parent == plan::kWorldWord
                        ? "place the child where the joint shall start"
                        : fmt::format("write location relative_to({}, (x, y, z))", sides.parent)};
}

/// Nothing else goes to a goal.
Fault FindGoalFault(const plan::Scene& scene, const plan::Joint& joint) {
  if (!joint.settings.Has(*GroupParameter("joints.goal")) || HasConfigurations(scene))
    return std::nullopt;
  return JointFault{"joints.goal",
                    fmt::format("{} has a goal, but the scene is simulated", TextOf(joint)),
                    "write configurations { positions path }, or a motor that seeks a position"};
}

Fault FindPartnerFault(const plan::Scene& scene, const plan::Joint& joint) {
  const auto fault = [&](std::string message, std::string help) {
    return JointFault{kGearWith, std::move(message), std::move(help)};
  };
  const std::string name(joint.settings.WordOr(kGearWith));
  const plan::Joint* partner = PartnerOf(scene, joint);
  if (partner == nullptr)
    return fault(fmt::format("there is no joint '{}'", name), "name a block of joints");
  if (!scene.HoldsObjects(*partner))
    return fault(fmt::format("{} is in gear with {}, which holds no objects", TextOf(joint), name),
                 "give its groups objects, or remove the gear");
  if (!HasPosition(*partner))
    return fault(fmt::format("{} is in gear with {}, whose type is {}", TextOf(joint), name,
                             partner->settings.WordOr(kType)),
                 "gears couple joints of the type hinge or slider");
  if (EndsInCircle(scene, joint))
    return fault(partner == &joint ? fmt::format("{} is in gear with itself", TextOf(joint))
                                   : fmt::format("the gears of {} end in a circle", TextOf(joint)),
                 "of joints in gear with each other, one has no gear.with");
  const std::uint64_t own = Sides(scene, joint).Count(), others = Sides(scene, *partner).Count();
  if (own != others && others != 1)
    return JointFault{
        kGearWith,
        fmt::format("{} holds {} pairs of objects, but is in gear with {}, which holds {}",
                    TextOf(joint), own, name, others),
        "give both the same quantity, or the other a single pair", Kind::kQuantity};
  return std::nullopt;
}

Fault FindGearFault(const plan::Scene& scene, const plan::Joint& joint) {
  if (joint.settings.WordOr(kGearWith) == "none") {
    for (const GroupParameter part : {GroupParameter(kGearRatio), GroupParameter(kGearOffset)})
      if (joint.settings.Has(*part))
        return JointFault{part, fmt::format("the gear of {} has no other joint", TextOf(joint)),
                          "name the joint that it is in gear with: gear.with NAME"};
    return std::nullopt;
  }
  if (!scene.HoldsObjects(joint)) return std::nullopt;
  if (Fault fault = FindPartnerFault(scene, joint)) return fault;
  const double ratio = joint.settings.Real(kGearRatio);
  if (ratio == 0)
    return JointFault{kGearRatio, fmt::format("the gear of {} has the ratio 0", TextOf(joint)),
                      "write type fixed, or a ratio that is not 0"};
  if (std::abs(ratio) < 1 / kMostRatio || std::abs(ratio) > kMostRatio)
    return JointFault{kGearRatio,
                      fmt::format("the gear of {} has the ratio {}, which single precision cannot "
                                  "compute with",
                                  TextOf(joint), schema::FormatReal(ratio)),
                      fmt::format("ratios are between {:g} and {:g}", 1 / kMostRatio, kMostRatio)};
  const std::optional<Gear> gear = GearOf(scene, joint);
  const double start = joint.settings.Real(kStart), other = gear->with->settings.Real(kStart);
  const double wanted = gear->ratio * other + gear->offset;
  if (std::abs(start - wanted) <=
      kGearRounding * (1 + std::abs(gear->ratio * other) + std::abs(gear->offset)))
    return std::nullopt;
  return JointFault{
      kGearOffset,
      fmt::format("{} starts at {}, but its gear with {} puts it at {}", TextOf(joint),
                  schema::FormatReal(start), joint.settings.WordOr(kGearWith),
                  schema::FormatReal(wanted)),
      fmt::format("write start {}, or gear.offset start", schema::FormatReal(wanted))};
}

/// A motor gives a torque, or seeks something; what it gives is of the type of the joint.
Fault FindTorqueFault(const plan::Joint& joint) {
  const GroupParameter torque = "joints.motor.torque", force = "joints.motor.force",
                       effort = "joints.motor.effort";
  const bool slides = joint.settings.WordOr(kType) == "slider";
  const GroupParameter wrong = slides ? torque : force;
  if (HasGoal(joint, wrong))
    return JointFault{wrong,
                      fmt::format("the motor of {}, whose type is {}, gives a {}", TextOf(joint),
                                  slides ? "slider" : "hinge", slides ? "torque" : "force"),
                      slides ? "write motor.force, in N" : "write motor.torque, in N m"};
  const GroupParameter given = slides ? force : torque;
  const char* what = slides ? "force" : "torque";
  if (!HasGoal(joint, given)) return std::nullopt;
  if (HasMotor(joint))
    return JointFault{given,
                      fmt::format("the motor of {} gives a {} and seeks a velocity or a position",
                                  TextOf(joint), what),
                      fmt::format("remove one of them; with motor.effort, a motor that seeks "
                                  "something has a largest {}",
                                  what)};
  if (HasNumber(joint, effort))
    return JointFault{
        effort, fmt::format("the motor of {} gives a {}, and needs no effort", TextOf(joint), what),
        "remove the effort"};
  return std::nullopt;
}

Fault FindMotorFault(const plan::Joint& joint) {
  const GroupParameter velocity = "joints.motor.velocity", position = "joints.motor.position",
                       effort = "joints.motor.effort";
  if (HasGoal(joint, velocity) && HasGoal(joint, position))
    return JointFault{position,
                      fmt::format("the motor of {} seeks a velocity and a position", TextOf(joint)),
                      "remove one of them"};
  if (Fault fault = FindTorqueFault(joint)) return fault;
  if (HasTorqueMotor(joint)) return std::nullopt;
  if (HasMotor(joint) == HasNumber(joint, effort)) return std::nullopt;
  if (HasMotor(joint))
    return JointFault{HasGoal(joint, velocity) ? velocity : position,
                      fmt::format("the motor of {} has no effort", TextOf(joint)),
                      "state its largest torque or force: motor.effort"};
  return JointFault{effort, fmt::format("the motor of {} is off", TextOf(joint)),
                    "give it a velocity or a position, or remove the effort"};
}

/// A rotor's inertia couples the two bodies of a joint, which Bullet's rigid bodies cannot do.
Fault FindArmatureFault(const plan::Scene& scene, const plan::Joint& joint) {
  const GroupParameter armature = "joints.armature";
  if (joint.settings.Real("joints.armature") == 0 ||
      scene.world.WordOr("coordinates") == "reduced" || HasConfigurations(scene))
    return std::nullopt;
  return JointFault{
      armature,
      fmt::format("{} has an armature, which joints in maximal coordinates cannot have",
                  TextOf(joint)),
      "write coordinates reduced and sleeping off, or remove the armature"};
}

std::optional<ReducedFault> FindReducedFault(const plan::Group& group) {
  const auto fault = [&](GroupParameter parameter, const char* what, const char* help) {
    return ReducedFault{
        group.name, parameter.get(),
        fmt::format("the {} are joined in reduced coordinates, {}", group.name, what), help};
  };
  const plan::GroupSettings& settings = group.settings;
  if (settings.WordOr("links.type") == "spring")
    return fault("links.type", "which have joints only, and no springs",
                 "write links of another type, or coordinates maximal");
  if (HasKinematic(group))
    return fault("mass", "and cannot be kinematic there",
                 "write a mass or mass fixed, or coordinates maximal");
  if (const auto* ccd = std::get_if<bool>(&settings.Get("ccd")); ccd == nullptr || *ccd)
    return fault("ccd", "whose links Bullet does not sweep", "write ccd off");
  for (const GroupParameter damping :
       {GroupParameter("linear_damping"), GroupParameter("angular_damping")})
    if (!schema::IsZero(settings.Get(damping)))
      return fault(damping, "which damp joints, and not objects",
                   "remove it, or give the joints damping");
  for (const GroupParameter velocity :
       {GroupParameter("linear_velocity"), GroupParameter("angular_velocity")})
    if (schema::AsCall(settings.Get(velocity)) != nullptr)
      return fault(velocity, "and a schedule cannot set their velocity there",
                   "write one velocity, or coordinates maximal");
  return std::nullopt;
}

}  // namespace

std::string TextOf(const plan::Joint& joint) {
  return joint.name == schema::kJointsBlock ? "the joint" : "the joint " + joint.name;
}

bool HasLimits(const plan::Joint& joint) { return HasNumber(joint, kLower); }

bool HasMotor(const plan::Joint& joint) {
  return HasGoal(joint, "joints.motor.velocity") || HasGoal(joint, "joints.motor.position");
}

bool HasTorqueMotor(const plan::Joint& joint) {
  return HasGoal(joint, "joints.motor.torque") || HasGoal(joint, "joints.motor.force");
}

bool IsJoined(const plan::Scene& scene, std::string_view group) {
  return std::ranges::any_of(scene.joints, [&](const plan::Joint& joint) {
    return scene.HoldsObjects(joint) &&
           (joint.settings.WordOr(kParent) == group || joint.settings.WordOr(kChild) == group);
  });
}

const plan::Joint* FindMotor(const plan::Scene& scene) { return FindJoint(scene, HasMotor); }

const plan::Joint* FindTorqueMotor(const plan::Scene& scene) {
  return FindJoint(scene, HasTorqueMotor);
}

const plan::Joint* FindLosses(const plan::Scene& scene) {
  return FindJoint(scene, [](const plan::Joint& joint) {
    return HasLimits(joint) || joint.settings.Real("joints.damping") > 0 ||
           joint.settings.Real("joints.friction") > 0;
  });
}

std::optional<Gear> GearOf(const plan::Scene& scene, const plan::Joint& joint) {
  if (!scene.HoldsObjects(joint) || joint.settings.WordOr(kGearWith) == "none") return std::nullopt;
  const plan::Joint* partner = PartnerOf(scene, joint);
  if (partner == nullptr || !HasPosition(joint) || !HasPosition(*partner) ||
      !scene.HoldsObjects(*partner) || EndsInCircle(scene, joint))
    return std::nullopt;
  Gear gear = {partner, joint.settings.Real(kGearRatio), 0};
  gear.offset = HasNumber(joint, kGearOffset)
                    ? joint.settings.Real(kGearOffset)
                    : joint.settings.Real(kStart) - gear.ratio * partner->settings.Real(kStart);
  return gear;
}

bool HasGears(const plan::Scene& scene) {
  return std::ranges::any_of(
      scene.joints, [&](const plan::Joint& joint) { return GearOf(scene, joint).has_value(); });
}

std::optional<JointFault> FindJointFault(const plan::Scene& scene, const plan::Joint& joint) {
  if (Fault fault = FindSideFault(scene, joint)) return fault;
  if (Fault fault = FindTypeFault(joint)) return fault;
  if (Fault fault = FindLimitFault(joint)) return fault;
  if (Fault fault = FindStartFault(scene, joint)) return fault;
  if (Fault fault = FindGoalFault(scene, joint)) return fault;
  if (Fault fault = FindGearFault(scene, joint)) return fault;
  if (Fault fault = FindArmatureFault(scene, joint)) return fault;
  return FindMotorFault(joint);
}

std::optional<ReducedFault> FindReducedFault(const plan::Scene& scene) {
  if (scene.world.WordOr("coordinates") != "reduced" || scene.PulledGroup().empty())
    return std::nullopt;
  if (scene.world.On("sleeping"))
    return ReducedFault{"", schema::WorldParameter("sleeping").get(),
                        "joints in reduced coordinates do not sleep, but sleeping is on",
                        "write sleeping off"};
  for (const plan::Group& group : scene.groups)
    if (group.settings.Count("quantity") > 0 && (group.HasLinks() || IsJoined(scene, group.name)))
      if (auto fault = FindReducedFault(group)) return fault;
  return std::nullopt;
}

}  // namespace cdb::analysis
