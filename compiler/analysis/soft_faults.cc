// What soft bodies cannot have, and what only they have.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "compiler/schema/series.h"

namespace cdb::analysis {
namespace {

using plan::Group;
using plan::Scene;
using MaybeFault = std::optional<SettingFault>;

/// Parameters of the world without a meaning beside soft bodies.
constexpr schema::WorldParameter kUnusedOfWorld[] = {"contact",
                                                     "coordinates",
                                                     "solver.erp",
                                                     "solver.warm_start",
                                                     "trace",
                                                     "accuracy.closed_form",
                                                     "accuracy.reference.contact",
                                                     "accuracy.reference.coordinates",
                                                     "accuracy.reference.sleeping"};
/// The same of a group of soft bodies.
constexpr schema::GroupParameter kUnusedOfGroup[] = {"collides_with",
                                                     "rolling_friction",
                                                     "spinning_friction",
                                                     "restitution",
                                                     "angular_damping",
                                                     "contact_stiffness",
                                                     "contact_damping",
                                                     "ccd",
                                                     "edges",
                                                     "e1",
                                                     "e2",
                                                     "links.type",
                                                     "force",
                                                     "torque"};
/// Of a rigid group beside soft bodies.
constexpr schema::GroupParameter kUnusedOfRigid[] = {
    "collides_with", "contact_stiffness", "contact_damping", "ccd", "links.type", "force",
    "torque"};
/// Of links, which solids do not have; and of the material, which only solids have.
constexpr schema::GroupParameter kOfLinks[] = {"soft.stiffness", "soft.damping"};
constexpr schema::GroupParameter kOfSolids[] = {"soft.material", "soft.young_modulus",
                                                "soft.poisson_ratio", "soft.stiffness_damping"};
/// Of one of the two worlds.
struct OfOneWorld {
  schema::GroupParameter parameter;
  std::string_view world;
};
constexpr OfOneWorld kOfOneWorld[] = {{"soft.correction", "positions"},
                                      {"linear_damping", "positions"},
                                      {"soft.stiffness", "springs"},
                                      {"soft.damping", "springs"},
                                      {"soft.self_collision", "springs"}};
constexpr std::string_view kRigidTypes[] = {"sphere",  "cuboid",      "cylinder",      "cone",
                                            "capsule", "tetrahedron", "superellipsoid"};
/// Nodes of a run, and of it alone: Bullet's arrays have int as their size.
constexpr std::uint64_t kMostNodes = 10'000'000;
/// Of one solid: a node takes 7 kB with its tetrahedra and links.
constexpr std::uint64_t kMostSolidNodes = 1'000'000;

MaybeFault OfWorld(schema::WorldParameter parameter, std::string message, std::string help,
                   std::string word = {}) {
  return SettingFault{{}, parameter.get(), std::move(word), std::move(message), std::move(help)};
}

/// Settings of soft bodies in a group that has none.
MaybeFault FindIdleInGroup(const Group& group) {
  for (const schema::Parameter& parameter : schema::Schema())
    if (parameter.name.starts_with("soft.") && group.settings.Has(parameter))
      return SettingFault{
          group.name,
          &parameter,
          {},
          fmt::format("'{}' is of soft bodies, and {} has none", parameter.name, group.name),
          "remove it, or write type rope(…), cloth(…), block(…) or soft(…)"};
  return std::nullopt;
}

/// Settings of soft bodies in a scene that has none.
MaybeFault FindIdle(const Scene& scene) {
  if (scene.world.Lists("record", "vertices"))
    return OfWorld("record", "'vertices' are those of soft bodies, and the scene has none",
                   "remove the word, or add objects of type rope(…), cloth(…), block(…) or soft(…)",
                   "vertices");
  for (const auto parameter :
       {schema::WorldParameter("soft_world"), schema::WorldParameter("soft_cell")})
    if (scene.world.Has(*parameter.get()))
      return OfWorld(parameter, "the scene has no soft bodies",
                     "remove it, or add objects of type rope(…), cloth(…), block(…) or soft(…)");
  return std::nullopt;
}

/// `what`: those that schedules do not reach.
MaybeFault FindScheduleFault(const Group& group, std::string_view what) {
  for (const auto parameter :
       {schema::GroupParameter("linear_velocity"), schema::GroupParameter("angular_velocity")})
    if (schema::AsCall(group.settings.Get(parameter)) != nullptr)
      return SettingFault{group.name,
                          parameter.get(),
                          {},
                          fmt::format("schedules do not reach {}", what),
                          "write a velocity at the start"};
  return std::nullopt;
}

MaybeFault FindMetricFault(const Scene& scene) {
  std::vector<std::string_view> measurable;
  for (const schema::Metric& metric : schema::Metrics())
    if (metric.on_soft) measurable.push_back(metric.name);
  for (const std::string& word : scene.world.Words("accuracy.metrics"))
    if (word != "none" && std::ranges::find(measurable, word) == measurable.end())
      return OfWorld("accuracy.metrics",
                     fmt::format("the error of '{}' cannot be measured of soft bodies", word),
                     fmt::format("those that can be: {}", fmt::join(measurable, ", ")), word);
  return std::nullopt;
}

MaybeFault FindWorldFault(const Scene& scene) {
  if (HasConfigurations(scene))
    return OfWorld("configurations.positions",
                   "configurations are those of rigid links, and the scene has soft bodies",
                   "remove the soft bodies, or configurations");
  for (const auto parameter : kUnusedOfWorld)
    if (scene.world.Has(*parameter.get()))
      return OfWorld(parameter,
                     fmt::format("'{}' has no meaning for soft bodies", parameter.name()),
                     "remove it, or the soft bodies");
  for (const schema::WorldParameter parameter :
       {schema::WorldParameter("detector"),
        schema::WorldParameter("accuracy.reference.detector")}) {
    const schema::Word* word = schema::AsWord(scene.world.Get(parameter));
    const std::string_view detector = word == nullptr ? "" : std::string_view(word->text);
    if (detector != "simple" && detector != "sap" && detector != "sap32" && detector != "dbvt")
      return OfWorld(parameter,
                     fmt::format("'{}' does not know soft bodies, whose pairs only Bullet's broad "
                                 "phases find",
                                 detector),
                     "use dbvt, sap32, sap or simple");
  }
  const std::string_view narrow = scene.world.WordOr("narrow_phase");
  if (narrow != "own" && narrow != "bullet")
    return OfWorld(
        "narrow_phase",
        fmt::format("'{}' does not know soft bodies, whose contacts only Bullet makes", narrow),
        "remove it, or write bullet");
  const schema::WorldParameter walls = "world.walls", wall_shape = "world.wall_shape";
  if (scene.world.WordOr("world.walls") != "none" &&
      scene.world.WordOr("world.wall_shape") == "plane")
    return OfWorld(scene.world.Has(*walls.get()) ? walls : wall_shape,
                   "Bullet makes soft bodies meet a plane as prisms of two triangles, above which "
                   "they float",
                   "write world { wall_shape box } or world { walls none }");
  const std::string_view expect = scene.world.WordOr("expect");
  if (expect == "rest" || expect == "energy")
    return OfWorld("expect",
                   fmt::format("whether soft bodies {} is not judged",
                               expect == "rest" ? "rest" : "keep their energy"),
                   "write expect anything, or remove it");
  std::vector<std::string_view> recordable;
  for (const schema::RecordWord& word : schema::kRecordWords)
    if (word.on_soft) recordable.push_back(word.name);
  for (const std::string& word : scene.world.Words("record"))
    if (std::ranges::find(recordable, word) == recordable.end())
      return OfWorld("record", fmt::format("'{}' cannot be recorded with soft bodies", word),
                     fmt::format("what can be: {}", fmt::join(recordable, ", ")), word);
  if (MaybeFault fault = FindMetricFault(scene)) return fault;
  if (schema::AsCall(scene.world.Get("acceleration")) != nullptr)
    return OfWorld("acceleration", "schedules do not reach the nodes of soft bodies",
                   "write a constant acceleration");
  if (NodeCount(scene) > kMostNodes)
    return OfWorld("cycles", fmt::format("the soft bodies have {} nodes", NodeCount(scene)),
                   fmt::format("a run may have {}", kMostNodes));
  return std::nullopt;
}

MaybeFault FindRigidFault(const Group& group) {
  const auto fault = [&](schema::GroupParameter parameter, std::string message, std::string help) {
    return SettingFault{group.name, parameter.get(), {}, std::move(message), std::move(help)};
  };
  const std::string_view type = group.settings.WordOr("type");
  if (std::ranges::find(kRigidTypes, type) == std::end(kRigidTypes))
    return fault(
        "type",
        fmt::format("beside soft bodies, the type of {} must be a convex closed form: only "
                    "of these is known whether a node is inside",
                    group.name),
        fmt::format("use {}", fmt::join(kRigidTypes, ", ")));
  for (const schema::GroupParameter parameter : kUnusedOfRigid)
    if (group.settings.Has(*parameter.get()))
      return fault(parameter,
                   fmt::format("'{}' has no meaning for {} beside soft bodies", parameter.name(),
                               group.name),
                   "remove it, or the soft bodies");
  const schema::Call* layout = schema::AsCall(group.settings.Get("location"));
  if (layout != nullptr && layout->name == "pile")
    return fault("location", "a pile is settled without soft bodies",
                 "use at, line, grid, stack or uniform");
  if (MaybeFault scheduled = FindScheduleFault(group, "rigid bodies beside soft ones"))
    return scheduled;
  return FindIdleInGroup(group);
}

MaybeFault FindPinFault(const Group& group, const schema::Call& type) {
  const bool is_rope = type.name == kRopeCall;
  const auto fault = [&](schema::GroupParameter parameter, std::string word, std::string message,
                         std::string help) {
    return SettingFault{group.name, parameter.get(), std::move(word), std::move(message),
                        std::move(help)};
  };
  for (const schema::GroupParameter parameter :
       {schema::GroupParameter("soft.pin"), schema::GroupParameter("soft.drive.pin")})
    for (const std::string& word : std::get<schema::WordList>(group.settings.Get(parameter))) {
      const bool is_of_sheet = word == "front" || word == "back" || word == "corners";
      const bool is_of_solid = word == "bottom" || word == "top";
      if ((is_rope && is_of_sheet) || (!IsSoftSolid(type) && is_of_solid))
        return fault(
            parameter, word, fmt::format("a {} has no '{}'", type.name, word),
            is_rope ? "use left, right or ends" : "use left, right, front, back, ends or corners");
      if (parameter.name() == "soft.drive.pin" && word != "none" &&
          group.settings.Lists("soft.pin", word))
        return fault(parameter, word,
                     fmt::format("the nodes of '{}' cannot both stay and move", word),
                     "remove it from soft.pin, or from soft.drive.pin");
    }
  constexpr schema::GroupParameter kVelocities[] = {"soft.drive.linear_velocity",
                                                    "soft.drive.angular_velocity"};
  for (const schema::GroupParameter parameter : kVelocities)
    if (!HasDrivenPins(group) && group.settings.Has(*parameter.get()))
      return fault(
          parameter, {},
          fmt::format("'{}' moves no nodes: soft.drive.pin names no side", parameter.name()),
          "write soft { drive { pin right } }, for example");
  if (HasDrivenPins(group) && std::ranges::all_of(kVelocities, [&](schema::GroupParameter name) {
        const Eigen::Vector3d* velocity = schema::AsVector(group.settings.Get(name));
        return velocity != nullptr && velocity->isZero(0);
      }))
    return fault(
        "soft.drive.pin", {}, "these nodes have no velocity",
        "write soft { drive { angular_velocity (2, 0, 0) } }, for example, or name them in "
        "soft.pin if they must stay");
  return std::nullopt;
}

std::string_view NameOf(const schema::Call& type) {
  return type.name == kSoftCall ? "soft solid" : std::string_view(type.name);
}

/// What only solids of tetrahedra have, and what they cannot have.
MaybeFault FindMaterialFault(const Scene& scene, const Group& group, const schema::Call& type) {
  const auto fault = [&](schema::GroupParameter parameter, std::string message, std::string help) {
    return SettingFault{group.name, parameter.get(), {}, std::move(message), std::move(help)};
  };
  const plan::GroupSettings& settings = group.settings;
  if (!IsSoftSolid(type)) {
    for (const schema::GroupParameter parameter : kOfSolids)
      if (settings.Has(*parameter.get()))
        return fault(parameter,
                     fmt::format("'{}' is of the material of blocks and soft( ), and a {} has none",
                                 parameter.name(), type.name),
                     scene.world.WordOr("soft_world") == "springs"
                         ? "remove it, or write soft { stiffness … }"
                         : "remove it");
    return std::nullopt;
  }
  if (const std::uint64_t nodes = NodeCount(settings.Get("type")); nodes > kMostSolidNodes)
    return fault("type", fmt::format("the {} has {} nodes", NameOf(type), nodes),
                 fmt::format("a {} may have {}", NameOf(type), kMostSolidNodes));
  if (scene.world.WordOr("soft_world") != "springs")
    return fault("type",
                 "soft_world positions knows no material: it would keep the edges of the "
                 "tetrahedra, and neither their volume nor a stiffness",
                 "write soft_world springs, Bullet's world of forces");
  for (const schema::GroupParameter parameter : kOfLinks)
    if (settings.Has(*parameter.get()))
      return fault(
          parameter,
          fmt::format("'{}' is of links, and a {} has a material", parameter.name(), NameOf(type)),
          "write soft { young_modulus … }");
  if (settings.On("soft.self_collision"))
    return fault("soft.self_collision",
                 fmt::format("the self-collision of {}s is not examined", NameOf(type)),
                 "remove it");
  if (settings.WordOr("soft.material") == "corotated" &&
      settings.Has(*schema::GroupParameter("soft.stiffness_damping").get()))
    return fault("soft.stiffness_damping", "Bullet's corotated material has no damping",
                 "remove it, or write soft { material neo_hookean }");
  return std::nullopt;
}

/// Lengths along y, and of a rope along z, are those of its margin, unless it is a solid.
MaybeFault FindAspectFault(const Group& group, const schema::Call& type) {
  if (IsSoftSolid(type)) return std::nullopt;
  const Eigen::Vector3d& aspect = std::get<schema::Ratio>(group.settings.Get("aspect")).parts;
  if (aspect.y() == 1 && (type.name == kClothCall || aspect.z() == 1)) return std::nullopt;
  return SettingFault{group.name,
                      schema::GroupParameter("aspect").get(),
                      {},
                      fmt::format("a {} is as thick as two margins", type.name),
                      type.name == kClothCall ? "write aspect 1 : 1 : z, and the margin"
                                              : "remove the aspect, and write the margin"};
}

MaybeFault FindGroupFault(const Scene& scene, const Group& group) {
  const plan::GroupSettings& settings = group.settings;
  const auto fault = [&](schema::GroupParameter parameter, std::string message, std::string help) {
    return SettingFault{group.name, parameter.get(), {}, std::move(message), std::move(help)};
  };
  const schema::Value& type = settings.Get("type");
  if (!IsSoft(type))
    return fault("type", "soft bodies of one group have one type, which is not drawn",
                 "write a group for each");
  const schema::Call& call = *schema::AsCall(type);
  const schema::Value& mass = settings.Get("mass");
  if (schema::AsNumber(mass) == nullptr)
    return fault("mass",
                 fmt::format("the mass of a soft body is a number, and that of {} is {}",
                             group.name, schema::ToText(mass)),
                 "write it in kg; pin what must not move: soft { pin ends }");
  if (schema::AsNumber(settings.Get("size")) == nullptr &&
      !(IsOfFile(type) && settings.WordOr("size") == "native"))
    return fault("size", "the size of a soft body is a number", "write it in m");
  for (const auto parameter : kUnusedOfGroup)
    if (settings.Has(*parameter.get()))
      return fault(parameter,
                   fmt::format("'{}' has no meaning for soft bodies, as those of {}",
                               parameter.name(), group.name),
                   "remove it");
  if (MaybeFault material = FindMaterialFault(scene, group, call)) return material;
  const std::string_view world = scene.world.WordOr("soft_world");
  for (const OfOneWorld& one : kOfOneWorld)
    if (one.world != world && settings.Has(*one.parameter.get()))
      return fault(one.parameter,
                   fmt::format("'{}' has a meaning only with soft_world {}", one.parameter.name(),
                               one.world),
                   fmt::format("remove it, or write soft_world {}", one.world));
  if (settings.On("soft.self_collision") && call.name == kRopeCall)
    return fault("soft.self_collision", "ropes have no faces that could collide", "remove it");
  if (MaybeFault scheduled = FindScheduleFault(group, "the nodes of soft bodies")) return scheduled;
  const schema::Call* layout = schema::AsCall(settings.Get("location"));
  if (layout != nullptr && (layout->name == "pile" || layout->name == "poses" ||
                            layout->name == "path" || layout->name == "relative_to"))
    return fault("location", fmt::format("'{}' does not place soft bodies", layout->name),
                 "use at, line, grid, stack or uniform");
  if (MaybeFault aspect = FindAspectFault(group, call)) return aspect;
  return FindPinFault(group, call);
}

}  // namespace

std::optional<SettingFault> FindSoftFault(const Scene& scene) {
  const bool has_soft = HasSoft(scene);
  if (!has_soft) {
    if (MaybeFault idle = FindIdle(scene)) return idle;
    for (const Group& group : scene.groups)
      if (group.settings.Count("quantity") > 0)
        if (MaybeFault idle = FindIdleInGroup(group)) return idle;
    return std::nullopt;
  }
  if (MaybeFault fault = FindWorldFault(scene)) return fault;
  for (const Group& group : scene.groups) {
    if (group.settings.Count("quantity") == 0) continue;
    if (MaybeFault fault = IsSoft(group) ? FindGroupFault(scene, group) : FindRigidFault(group))
      return fault;
  }
  for (const plan::Joint& joint : scene.joints)
    if (scene.HoldsObjects(joint))
      return SettingFault{
          joint.name,
          schema::GroupParameter("joints.child").get(),
          {},
          "joints do not hold the nodes of soft bodies, nor rigid objects beside them",
          "remove it; pin nodes where they start: soft { pin ends }"};
  for (const plan::Queries& queries : scene.queries)
    if (queries.settings.Count("queries.count") > 0)
      return SettingFault{queries.name,
                          schema::GroupParameter("queries.type").get(),
                          {},
                          "queries do not know soft bodies, and would miss them",
                          "remove them, or the soft bodies"};
  return std::nullopt;
}

}  // namespace cdb::analysis
