#include "compiler/analysis/soft.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/trace.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"
#include "compiler/schema/series.h"

namespace cdb::analysis {
namespace {

using plan::Group;
using plan::Scene;

std::size_t CountOf(const schema::Call& call, std::string_view argument) {
  return std::get<schema::Number>(schema::ArgumentOf(call, argument)).AsCount();
}

bool HasObjects(const Group& group) { return group.settings.Count("quantity") > 0; }

}  // namespace

bool IsSoft(const schema::Value& type) {
  const schema::Call* call = schema::AsCall(type);
  return call != nullptr && (call->name == kRopeCall || call->name == kClothCall);
}

bool IsSoft(const Group& group) {
  const schema::Value& type = group.settings.Get("type");
  const schema::Distribution* drawn = schema::AsDistribution(type);
  return HasObjects(group) &&
         (drawn != nullptr
              ? std::ranges::any_of(drawn->arguments,
                                    [](const schema::Value& choice) { return IsSoft(choice); })
              : IsSoft(type));
}

bool HasSoft(const Scene& scene) {
  return std::ranges::any_of(scene.groups, [](const Group& group) { return IsSoft(group); });
}

std::uint64_t NodeCount(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Group& group : scene.groups) {
    const schema::Value& type = group.settings.Get("type");
    if (!IsSoft(group) || !IsSoft(type)) continue;
    const schema::Call& call = *schema::AsCall(type);
    const std::uint64_t nodes = call.name == kRopeCall
                                    ? CountOf(call, "segments") + 1
                                    : (CountOf(call, "columns") + 1) * (CountOf(call, "rows") + 1);
    count += group.settings.Count("quantity") * nodes;
  }
  return count;
}

std::uint64_t FreeRigidCount(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Group& group : scene.groups) {
    const std::string_view mass = group.settings.WordOr("mass");
    if (!IsSoft(group) && mass != "fixed" && mass != "kinematic")
      count += group.settings.Count("quantity");
  }
  return count;
}

std::pair<double, double> SoftMesh::PlaceOf(std::size_t node) const {
  const auto x = static_cast<double>(node % (columns + 1)) / static_cast<double>(columns);
  const auto z = static_cast<double>(node / (columns + 1));
  return {x, rows == 0 ? 0.5 : z / static_cast<double>(rows)};
}

SoftMesh MeshOf(const schema::Value& type) {
  const schema::Call& call = *schema::AsCall(type);
  SoftMesh mesh;
  const bool is_rope = call.name == kRopeCall;
  mesh.columns = CountOf(call, is_rope ? "segments" : "columns");
  mesh.rows = is_rope ? 0 : CountOf(call, "rows");
  const auto node = [&](std::size_t x, std::size_t z) {
    return static_cast<std::uint32_t>(z * (mesh.columns + 1) + x);
  };
  for (std::size_t z = 0; z <= mesh.rows; ++z)
    for (std::size_t x = 0; x <= mesh.columns; ++x) {
      if (x < mesh.columns) mesh.links.push_back({node(x, z), node(x + 1, z)});
      if (z < mesh.rows) mesh.links.push_back({node(x, z), node(x, z + 1)});
      if (x == mesh.columns || z == mesh.rows) continue;
      const std::uint32_t a = node(x, z), b = node(x + 1, z), c = node(x + 1, z + 1),
                          d = node(x, z + 1);
      if ((x + z) % 2 == 0) {
        mesh.links.push_back({a, c});
        mesh.triangles.push_back({a, c, b});
        mesh.triangles.push_back({a, d, c});
      } else {
        mesh.links.push_back({b, d});
        mesh.triangles.push_back({a, d, b});
        mesh.triangles.push_back({b, d, c});
      }
    }
  return mesh;
}

std::vector<double> MassShares(const SoftMesh& mesh) {
  std::vector<double> shares(mesh.NodeCount(), 0.0);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t node : triangle)
      shares[node] += 1 / (3 * static_cast<double>(mesh.triangles.size()));
  if (!mesh.triangles.empty()) return shares;
  for (const auto& link : mesh.links)
    for (const std::uint32_t node : link)
      shares[node] += 1 / (2 * static_cast<double>(mesh.links.size()));
  return shares;
}

std::vector<std::uint32_t> PinnedNodes(const Group& group) {
  const SoftMesh mesh = MeshOf(group.settings.Get("type"));
  const std::size_t width = mesh.columns + 1;
  std::vector<std::uint32_t> pinned;
  for (std::size_t node = 0; node < mesh.NodeCount(); ++node) {
    const std::size_t x = node % width, z = node / width;
    const bool is_left = x == 0, is_right = x == mesh.columns, is_back = z == 0,
               is_front = z == mesh.rows;
    const auto is_pinned_by = [&](const std::string& word) {
      if (word == "left") return is_left;
      if (word == "right") return is_right;
      if (word == "ends") return is_left || is_right;
      if (word == "back") return is_back;
      if (word == "front") return is_front;
      return word == "corners" && (is_left || is_right) && (is_back || is_front);
    };
    if (std::ranges::any_of(group.settings.Words("soft.pin"), is_pinned_by))
      pinned.push_back(static_cast<std::uint32_t>(node));
  }
  return pinned;
}

namespace {

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
          "remove it, or write type rope(…) or cloth(…)"};
  return std::nullopt;
}

/// Settings of soft bodies in a scene that has none.
MaybeFault FindIdle(const Scene& scene) {
  if (scene.world.Lists("record", "vertices"))
    return OfWorld("record", "'vertices' are those of soft bodies, and the scene has none",
                   "remove the word, or add objects of type rope(…) or cloth(…)", "vertices");
  for (const auto parameter :
       {schema::WorldParameter("soft_world"), schema::WorldParameter("soft_cell")})
    if (scene.world.Has(*parameter.get()))
      return OfWorld(parameter, "the scene has no soft bodies",
                     "remove it, or add objects of type rope(…) or cloth(…)");
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
    return fault("type",
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
  for (const std::string& word : group.settings.Words("soft.pin")) {
    const bool is_of_cloth = word == "front" || word == "back" || word == "corners";
    if (type.name == kRopeCall && is_of_cloth)
      return SettingFault{group.name, schema::GroupParameter("soft.pin").get(), word,
                          fmt::format("a rope has no '{}'", word), "use left, right or ends"};
  }
  return std::nullopt;
}

/// Lengths along y, and of a rope along z, are those of its margin.
MaybeFault FindAspectFault(const Group& group, const schema::Call& type) {
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
  if (schema::AsNumber(settings.Get("size")) == nullptr)
    return fault("size", "the size of a soft body is a number", "write it in m");
  for (const auto parameter : kUnusedOfGroup)
    if (settings.Has(*parameter.get()))
      return fault(parameter,
                   fmt::format("'{}' has no meaning for soft bodies, as those of {}",
                               parameter.name(), group.name),
                   "remove it");
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
      if (HasObjects(group))
        if (MaybeFault idle = FindIdleInGroup(group)) return idle;
    return std::nullopt;
  }
  if (MaybeFault fault = FindWorldFault(scene)) return fault;
  for (const Group& group : scene.groups) {
    if (!HasObjects(group)) continue;
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
