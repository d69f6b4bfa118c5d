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

constexpr std::string_view kSoftCalls[] = {kRopeCall, kClothCall, kBlockCall};

bool HasObjects(const Group& group) { return group.settings.Count("quantity") > 0; }

std::size_t CountOf(const schema::Call& call, std::string_view argument) {
  return std::get<schema::Number>(schema::ArgumentOf(call, argument)).AsCount();
}

/// Of a rope or a cloth.
void AddSheet(SoftMesh& mesh) {
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
}

/// Corners of a cell by the bits of their numbers: 1 is towards +x, 2 towards +y, 4 towards +z.
using Tetrahedron = std::array<std::uint32_t, 4>;
constexpr Tetrahedron kOfEvenCell[] = {
    {0, 1, 2, 4}, {3, 2, 1, 7}, {5, 1, 4, 7}, {6, 4, 2, 7}, {1, 2, 4, 7}};
/// The triangles of a tetrahedron of positive volume, counterclockwise from outside.
constexpr std::array<std::size_t, 3> kFaces[] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

void AddTetrahedra(SoftMesh& mesh) {
  for (std::size_t y = 0; y < mesh.layers; ++y)
    for (std::size_t z = 0; z < mesh.rows; ++z)
      for (std::size_t x = 0; x < mesh.columns; ++x) {
        const bool is_mirrored = (x + y + z) % 2 == 1;
        for (const Tetrahedron& corners : kOfEvenCell) {
          Tetrahedron& made = mesh.tetrahedra.emplace_back();
          for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t corner = is_mirrored ? corners[i] ^ 1 : corners[i];
            made[i] = static_cast<std::uint32_t>(
                ((y + (corner >> 1 & 1)) * (mesh.rows + 1) + z + (corner >> 2)) *
                    (mesh.columns + 1) +
                x + (corner & 1));
          }
          if (is_mirrored) std::swap(made[2], made[3]);
        }
      }
}

/// Of the tetrahedra, each once.
void AddEdges(SoftMesh& mesh) {
  for (const Tetrahedron& one : mesh.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        mesh.links.push_back({std::min(one[i], one[j]), std::max(one[i], one[j])});
  std::ranges::sort(mesh.links);
  const auto repeated = std::ranges::unique(mesh.links);
  mesh.links.erase(repeated.begin(), repeated.end());
}

/// The faces of tetrahedra that lie in a side of the block.
void AddSurface(SoftMesh& mesh) {
  for (const Tetrahedron& one : mesh.tetrahedra)
    for (const auto& face : kFaces) {
      const std::array<std::uint32_t, 3> corners = {one[face[0]], one[face[1]], one[face[2]]};
      const Eigen::Array3d a = mesh.PlaceOf(corners[0]), b = mesh.PlaceOf(corners[1]),
                           c = mesh.PlaceOf(corners[2]);
      const Eigen::Array3d least = a.min(b).min(c), most = a.max(b).max(c);
      if (most.minCoeff() == 0 || least.maxCoeff() == 1) mesh.triangles.push_back(corners);
    }
}

}  // namespace

bool IsSoft(const schema::Value& type) {
  const schema::Call* call = schema::AsCall(type);
  return call != nullptr && std::ranges::find(kSoftCalls, call->name) != std::end(kSoftCalls);
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

bool HasBlocks(const Group& group) {
  const schema::Value& type = group.settings.Get("type");
  return HasObjects(group) && IsSoft(type) && schema::AsCall(type)->name == kBlockCall;
}

std::uint64_t NodeCount(const schema::Value& type) {
  std::uint64_t count = 1;
  for (const schema::Value& cells : schema::AsCall(type)->arguments)  // along one axis
    count *= std::get<schema::Number>(cells).AsCount() + 1;
  return count;
}

std::uint64_t NodeCount(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Group& group : scene.groups) {
    const schema::Value& type = group.settings.Get("type");
    if (IsSoft(group) && IsSoft(type)) count += group.settings.Count("quantity") * NodeCount(type);
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

Eigen::Vector3d SoftMesh::PlaceOf(std::size_t node) const {
  const auto part = [](std::size_t place, std::size_t cells) {
    return cells == 0 ? 0.5 : static_cast<double>(place) / static_cast<double>(cells);
  };
  const std::size_t x = node % (columns + 1), line = node / (columns + 1);
  return {part(x, columns), part(line / (rows + 1), layers), part(line % (rows + 1), rows)};
}

SoftMesh BlockOf(std::size_t columns, std::size_t rows, std::size_t layers) {
  SoftMesh mesh{columns, rows, layers, {}, {}, {}};
  AddTetrahedra(mesh);
  AddEdges(mesh);
  AddSurface(mesh);
  return mesh;
}

SoftMesh LatticeOf(const schema::Value& type) {
  const schema::Call& call = *schema::AsCall(type);
  SoftMesh mesh;
  mesh.columns = CountOf(call, call.name == kRopeCall ? "segments" : "columns");
  if (call.name != kRopeCall) mesh.rows = CountOf(call, "rows");
  if (call.name == kBlockCall) mesh.layers = CountOf(call, "layers");
  return mesh;
}

SoftMesh MeshOf(const schema::Value& type) {
  SoftMesh mesh = LatticeOf(type);
  if (mesh.layers > 0) return BlockOf(mesh.columns, mesh.rows, mesh.layers);
  AddSheet(mesh);
  return mesh;
}

std::vector<double> MassShares(const SoftMesh& mesh) {
  std::vector<double> shares(mesh.NodeCount(), 0.0);
  const auto add = [&](const auto& parts, double whole) {
    for (const auto& part : parts)
      for (const std::uint32_t node : part)
        shares[node] += whole / static_cast<double>(part.size() * parts.size());
  };
  if (mesh.tetrahedra.empty()) {
    if (mesh.triangles.empty()) {
      add(mesh.links, 1);
    } else {
      add(mesh.triangles, 1);
    }
    return shares;
  }
  // The fifth of each cell is a third of it, the others are a sixth.
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    for (const std::uint32_t node : mesh.tetrahedra[i])
      shares[node] +=
          (i % 5 == 4 ? 2.0 : 1.0) * 5 / (24.0 * static_cast<double>(mesh.tetrahedra.size()));
  return shares;
}

std::vector<std::uint32_t> PinnedNodes(const Group& group, const SoftMesh& mesh) {
  std::vector<std::uint32_t> pinned;
  for (std::size_t node = 0; node < mesh.NodeCount(); ++node) {
    const Eigen::Vector3d place = mesh.PlaceOf(node);
    const bool is_left = place.x() == 0, is_right = place.x() == 1, is_back = place.z() == 0,
               is_front = place.z() == 1, is_bottom = place.y() == 0, is_top = place.y() == 1;
    const auto is_pinned_by = [&](const std::string& word) {
      if (word == "left") return is_left;
      if (word == "right") return is_right;
      if (word == "ends") return is_left || is_right;
      if (word == "back") return is_back;
      if (word == "front") return is_front;
      if (word == "bottom") return is_bottom;
      if (word == "top") return is_top;
      return word == "corners" && (is_left || is_right) && (is_back || is_front) &&
             (mesh.layers == 0 || is_bottom || is_top);
    };
    if (std::ranges::any_of(group.settings.Words("soft.pin"), is_pinned_by))
      pinned.push_back(static_cast<std::uint32_t>(node));
  }
  return pinned;
}

LameConstants LameConstantsOf(double young_modulus, double poisson_ratio) {
  return {young_modulus / (2 * (1 + poisson_ratio)),
          young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))};
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
/// Of links, which blocks do not have; and of the material, which only blocks have.
constexpr schema::GroupParameter kOfLinks[] = {"soft.stiffness", "soft.damping"};
constexpr schema::GroupParameter kOfBlocks[] = {"soft.material", "soft.young_modulus",
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
/// Of one block: a node takes 7 kB with its tetrahedra and links.
constexpr std::uint64_t kMostBlockNodes = 1'000'000;

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
          "remove it, or write type rope(…), cloth(…) or block(…)"};
  return std::nullopt;
}

/// Settings of soft bodies in a scene that has none.
MaybeFault FindIdle(const Scene& scene) {
  if (scene.world.Lists("record", "vertices"))
    return OfWorld("record", "'vertices' are those of soft bodies, and the scene has none",
                   "remove the word, or add objects of type rope(…), cloth(…) or block(…)",
                   "vertices");
  for (const auto parameter :
       {schema::WorldParameter("soft_world"), schema::WorldParameter("soft_cell")})
    if (scene.world.Has(*parameter.get()))
      return OfWorld(parameter, "the scene has no soft bodies",
                     "remove it, or add objects of type rope(…), cloth(…) or block(…)");
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
  const bool is_rope = type.name == kRopeCall, is_block = type.name == kBlockCall;
  for (const std::string& word : group.settings.Words("soft.pin")) {
    const bool is_of_sheet = word == "front" || word == "back" || word == "corners";
    const bool is_of_block = word == "bottom" || word == "top";
    if ((is_rope && is_of_sheet) || (!is_block && is_of_block))
      return SettingFault{
          group.name, schema::GroupParameter("soft.pin").get(), word,
          fmt::format("a {} has no '{}'", type.name, word),
          is_rope ? "use left, right or ends" : "use left, right, front, back, ends or corners"};
  }
  return std::nullopt;
}

/// What only blocks have, and what they cannot have.
MaybeFault FindMaterialFault(const Scene& scene, const Group& group, const schema::Call& type) {
  const auto fault = [&](schema::GroupParameter parameter, std::string message, std::string help) {
    return SettingFault{group.name, parameter.get(), {}, std::move(message), std::move(help)};
  };
  const plan::GroupSettings& settings = group.settings;
  if (type.name != kBlockCall) {
    for (const schema::GroupParameter parameter : kOfBlocks)
      if (settings.Has(*parameter.get()))
        return fault(parameter,
                     fmt::format("'{}' is of the material of blocks, and a {} has none",
                                 parameter.name(), type.name),
                     scene.world.WordOr("soft_world") == "springs"
                         ? "remove it, or write soft { stiffness … }"
                         : "remove it");
    return std::nullopt;
  }
  if (const std::uint64_t nodes = NodeCount(settings.Get("type")); nodes > kMostBlockNodes)
    return fault("type", fmt::format("the block has {} nodes", nodes),
                 fmt::format("a block may have {}", kMostBlockNodes));
  if (scene.world.WordOr("soft_world") != "springs")
    return fault("type",
                 "soft_world positions knows no material: it would keep the edges of the "
                 "tetrahedra, and neither their volume nor a stiffness",
                 "write soft_world springs, Bullet's world of forces");
  for (const schema::GroupParameter parameter : kOfLinks)
    if (settings.Has(*parameter.get()))
      return fault(parameter,
                   fmt::format("'{}' is of links, and a block has a material", parameter.name()),
                   "write soft { young_modulus … }");
  if (settings.On("soft.self_collision"))
    return fault("soft.self_collision", "the self-collision of blocks is not examined",
                 "remove it");
  if (settings.WordOr("soft.material") == "corotated" &&
      settings.Has(*schema::GroupParameter("soft.stiffness_damping").get()))
    return fault("soft.stiffness_damping", "Bullet's corotated material has no damping",
                 "remove it, or write soft { material neo_hookean }");
  return std::nullopt;
}

/// Lengths along y, and of a rope along z, are those of its margin, unless it is a block.
MaybeFault FindAspectFault(const Group& group, const schema::Call& type) {
  if (type.name == kBlockCall) return std::nullopt;
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
