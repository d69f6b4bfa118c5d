#include "compiler/analysis/soft.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "compiler/schema/schema.h"

namespace cdb::analysis {
namespace {

using plan::Group;
using plan::Scene;

constexpr std::string_view kSoftCalls[] = {kRopeCall, kClothCall, kBlockCall, kSoftCall};

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

/// The faces that only one tetrahedron has, in the order of the tetrahedra.
void AddSurface(SoftMesh& mesh) {
  using Corners = std::array<std::uint32_t, 3>;
  struct Face {
    Corners sorted, corners;
    std::size_t number;
  };
  std::vector<Face> faces;
  for (const Tetrahedron& one : mesh.tetrahedra)
    for (const auto& face : kFaces) {
      const Corners corners = {one[face[0]], one[face[1]], one[face[2]]};
      faces.push_back({corners, corners, faces.size()});
      std::ranges::sort(faces.back().sorted);
    }
  std::ranges::sort(faces, {},
                    [](const Face& face) { return std::pair(face.sorted, face.number); });
  std::vector<Face> outer;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + 1 < faces.size() && faces[i].sorted == faces[i + 1].sorted) {
      ++i;
    } else {
      outer.push_back(faces[i]);
    }
  }
  std::ranges::sort(outer, {}, &Face::number);
  for (const Face& face : outer) mesh.triangles.push_back(face.corners);
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

bool IsSoftSolid(const schema::Value& type) {
  const schema::Call* call = schema::AsCall(type);
  return call != nullptr && (call->name == kBlockCall || call->name == kSoftCall);
}

bool HasSoftSolids(const Group& group) {
  return HasObjects(group) && IsSoftSolid(group.settings.Get("type"));
}

bool IsOfFile(const schema::Value& type) {
  const schema::Call* call = schema::AsCall(type);
  return call != nullptr && call->name == kSoftCall;
}

bool HasDrivenPins(const Group& group) {
  return IsSoft(group) && !group.settings.Lists("soft.drive.pin", "none");
}

std::uint64_t NodeCount(const schema::Value& type) {
  if (IsOfFile(type)) {
    const schema::Number* nodes =
        schema::AsNumber(schema::ArgumentOf(*schema::AsCall(type), "nodes"));
    return nodes != nullptr ? nodes->AsCount() : 0;
  }
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
  if (!places.empty()) return places[node];
  const auto part = [](std::size_t place, std::size_t cells) {
    return cells == 0 ? 0.5 : static_cast<double>(place) / static_cast<double>(cells);
  };
  const std::size_t x = node % (columns + 1), line = node / (columns + 1);
  return {part(x, columns), part(line / (rows + 1), layers), part(line % (rows + 1), rows)};
}

SoftMesh BlockOf(std::size_t columns, std::size_t rows, std::size_t layers) {
  SoftMesh mesh;
  mesh.columns = columns;
  mesh.rows = rows;
  mesh.layers = layers;
  AddTetrahedra(mesh);
  AddLinksAndTriangles(mesh);
  return mesh;
}

void AddLinksAndTriangles(SoftMesh& mesh) {
  AddEdges(mesh);
  AddSurface(mesh);
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
  if (!mesh.places.empty()) {
    double whole = 0;
    for (const Tetrahedron& one : mesh.tetrahedra) {
      const double volume =
          EdgesOf(one, [&](std::uint32_t node) { return mesh.places[node]; }).determinant();
      for (const std::uint32_t node : one) shares[node] += volume / 4;
      whole += volume;
    }
    for (double& share : shares) share /= whole;
    return shares;
  }
  // The fifth of each cell is a third of it, the others are a sixth.
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    for (const std::uint32_t node : mesh.tetrahedra[i])
      shares[node] +=
          (i % 5 == 4 ? 2.0 : 1.0) * 5 / (24.0 * static_cast<double>(mesh.tetrahedra.size()));
  return shares;
}

namespace {

std::vector<std::uint32_t> NodesAt(const std::vector<std::string>& sides, const SoftMesh& mesh) {
  std::vector<std::uint32_t> nodes;
  const bool has_layers = mesh.layers > 0 || !mesh.places.empty();
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Ones();
  if (!mesh.places.empty()) {
    low = high = mesh.places[0];
    for (const Eigen::Vector3d& place : mesh.places) {
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    low += mesh.side_depth;
    high -= mesh.side_depth;
  }
  for (std::size_t node = 0; node < mesh.NodeCount(); ++node) {
    const Eigen::Vector3d place = mesh.PlaceOf(node);
    const auto is_low = [&](int axis) { return place[axis] <= low[axis]; };
    const auto is_high = [&](int axis) { return place[axis] >= high[axis]; };
    const bool is_end = is_low(0) || is_high(0);
    const auto is_at = [&](const std::string& word) {
      if (word == "left") return is_low(0);
      if (word == "right") return is_high(0);
      if (word == "ends") return is_end;
      if (word == "back") return is_low(2);
      if (word == "front") return is_high(2);
      if (word == "bottom") return is_low(1);
      if (word == "top") return is_high(1);
      return word == "corners" && is_end && (is_low(2) || is_high(2)) &&
             (!has_layers || is_low(1) || is_high(1));
    };
    if (std::ranges::any_of(sides, is_at)) nodes.push_back(static_cast<std::uint32_t>(node));
  }
  return nodes;
}

}  // namespace

std::vector<std::uint32_t> PinnedNodes(const Group& group, const SoftMesh& mesh) {
  return NodesAt(group.settings.Words("soft.pin"), mesh);
}

std::vector<std::uint32_t> DrivenNodes(const Group& group, const SoftMesh& mesh) {
  const std::vector<std::uint32_t> at = NodesAt(group.settings.Words("soft.drive.pin"), mesh),
                                   pinned = PinnedNodes(group, mesh);
  std::vector<std::uint32_t> driven;
  std::ranges::set_difference(at, pinned, std::back_inserter(driven));
  return driven;
}

LameConstants LameConstantsOf(double young_modulus, double poisson_ratio) {
  return {young_modulus / (2 * (1 + poisson_ratio)),
          young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))};
}

}  // namespace cdb::analysis
