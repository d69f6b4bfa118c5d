#include "library/meshes/decompose.h"

#include <fmt/format.h>
#include <hacdHACD.h>
#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "dsl/text/check.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/overlap_volume.h"
#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

/// To be incremented whenever the same mesh and options would give different pieces or figures.
constexpr int kAlgorithm = 1;

double VolumeOf(const Hull& hull) { return SignedVolume(SurfaceOf(hull)); }

/// Splits each triangle into four, repeatedly, up to about `faces` triangles. HACD judges a piece
/// by its vertices and the middles of its faces: with few large faces it makes a hollow shell.
void Subdivide(Mesh& mesh, std::size_t faces) {
  while (4 * mesh.triangles.size() <= faces + faces / 4) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t from, std::uint32_t to) {
      const auto next = static_cast<std::uint32_t>(mesh.vertices.size());
      const auto [at, is_new] = middles.try_emplace(std::minmax(from, to), next);
      if (is_new) mesh.vertices.push_back((mesh.vertices[from] + mesh.vertices[to]) / 2);
      return at->second;
    };
    std::vector<Triangle> quarters;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      quarters.insert(quarters.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(quarters);
  }
}

/// The triangles of a coarser mesh with the same vertices.
std::vector<Triangle> Simplified(const Mesh& mesh, std::size_t faces, std::string_view name) {
  if (mesh.triangles.size() <= faces) return mesh.triangles;
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  // meshoptimizer uses single precision: relative to the middle, in units of the longest side.
  std::vector<float> positions;
  for (const Vector3d& vertex : mesh.vertices)
    for (const double x : Vector3d((vertex - box.center()) / box.sizes().maxCoeff()))
      positions.push_back(static_cast<float>(x));
  std::vector<unsigned> indices, coarse;
  for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  coarse.resize(indices.size());
  // Only the number of faces limits the simplification, not the error.
  coarse.resize(meshopt_simplify(coarse.data(), indices.data(), indices.size(), positions.data(),
                                 mesh.vertices.size(), 3 * sizeof(float), 3 * faces, 1.0f, 0,
                                 nullptr));
  // The time of HACD grows with the square of the number of faces.
  if (coarse.size() / 3 > 2 * faces)
    throw library::SceneError(
        fmt::format("{}: cannot be simplified below {} faces, but decomposing more than {} takes "
                    "too long; use fewer separate parts or holes, or its convex hull",
                    name, coarse.size() / 3, 2 * faces));
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i + 2 < coarse.size(); i += 3)
    triangles.push_back({coarse[i], coarse[i + 1], coarse[i + 2]});
  return triangles;
}

/// By piece, the vertices of its faces, in ascending order.
std::vector<std::vector<std::uint32_t>> Clusters(const Mesh& mesh, double compacity,
                                                 const DecomposeOptions& options,
                                                 std::string_view name) {
  const std::vector<Triangle>& triangles = mesh.triangles;
  // HACD moves the points, and includes unused ones in its scale.
  std::vector<std::int64_t> number(mesh.vertices.size(), -1);
  std::vector<HACD::Vec3<HACD::Real>> points;
  std::vector<HACD::Vec3<long>> faces;
  for (const Triangle& t : triangles) {
    for (const std::uint32_t vertex : t) {
      if (number[vertex] >= 0) continue;
      number[vertex] = static_cast<std::int64_t>(points.size());
      const Vector3d& p = mesh.vertices[vertex];
      points.emplace_back(p.x(), p.y(), p.z());
    }
    faces.emplace_back(number[t[0]], number[t[1]], number[t[2]]);
  }
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  HACD::HACD hacd;
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(faces.data());
  hacd.SetNTriangles(faces.size());
  hacd.SetCompacityWeight(compacity);
  hacd.SetVolumeWeight(0);
  hacd.SetNClusters(options.least_pieces);
  hacd.SetNVerticesPerCH(options.vertices_per_hull);
  hacd.SetConcavity(options.concavity);
  hacd.SetAddExtraDistPoints(true);
  hacd.SetAddNeighboursDistPoints(true);
  hacd.SetAddFacesPoints(true);
  if (!hacd.Compute()) throw library::SceneError(fmt::format("{}: HACD cannot decompose it", name));
  std::vector<std::vector<std::uint32_t>> clusters(hacd.GetNClusters());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const long cluster = hacd.GetPartition()[i];
    CDB_CHECK(cluster >= 0 && static_cast<std::size_t>(cluster) < clusters.size());
    auto& vertices = clusters[static_cast<std::size_t>(cluster)];
    vertices.insert(vertices.end(), triangles[i].begin(), triangles[i].end());
  }
  for (auto& vertices : clusters) {
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  }
  return clusters;
}

std::vector<Hull> Pieces(const Mesh& mesh, double volume, double compacity,
                         const DecomposeOptions& options, std::string_view name) {
  std::vector<Hull> hulls;
  for (const auto& cluster : Clusters(mesh, compacity, options, name)) {
    std::vector<Vector3d> points;
    for (const std::uint32_t vertex : cluster) points.push_back(mesh.vertices[vertex]);
    const std::optional<Hull> hull = TryConvexHull(points);
    if (!hull) continue;  // a flat patch, without volume
    Hull fewer = WithFewerVertices(*hull, options.vertices_per_hull);
    if (VolumeOf(fewer) >= options.least_volume * volume) hulls.push_back(std::move(fewer));
  }
  return hulls;
}

}  // namespace

Decomposition Assessed(std::vector<Hull> hulls, const Mesh& mesh) {
  Mesh surfaces;
  for (const Hull& hull : hulls) {
    const auto base = static_cast<std::uint32_t>(surfaces.vertices.size());
    const Mesh surface = SurfaceOf(hull);
    surfaces.vertices.insert(surfaces.vertices.end(), surface.vertices.begin(),
                             surface.vertices.end());
    for (const Triangle& t : surface.triangles)
      surfaces.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
  const OverlapVolume volume = OverlapVolumeOf(mesh, surfaces);
  return {std::move(hulls), std::abs(volume.second - volume.first) / volume.first,
          volume.IntersectionOverUnion()};
}

Decomposition Decompose(const Mesh& mesh, std::string_view name, const DecomposeOptions& options) {
  CDB_CHECK(options.faces >= 4 && options.vertices_per_hull >= 4 && options.concavity > 0);
  const double volume = SignedVolume(mesh);
  const Hull whole = ConvexHull(mesh, name);
  if (VolumeOf(whole) - volume <= 1e-4 * volume)
    return Assessed({WithFewerVertices(whole, options.vertices_per_hull)}, mesh);
  Mesh even{mesh.vertices, Simplified(mesh, options.faces, name)};
  Subdivide(even, options.faces);
  // HACD's pieces change with any small change of the input; if they happen to be bad, another
  // weight of the compacity usually gives good ones.
  Decomposition best;
  for (const double factor : {1.0, 0.1, 0.01}) {
    std::vector<Hull> hulls = Pieces(even, volume, factor * options.compacity, options, name);
    if (hulls.empty()) continue;
    Decomposition next = Assessed(std::move(hulls), mesh);
    if (next.iou > best.iou) best = std::move(next);
    if (best.iou >= options.good_iou) break;
  }
  if (best.hulls.empty())
    throw library::SceneError(
        fmt::format("{}: its convex pieces are flat; use its convex hull", name));
  return best;
}

std::string DecomposerVersion() {
  const auto& [faces, concavity, compacity, least_pieces, vertices_per_hull, least_volume,
               good_iou] = DecomposeOptions{};
  return fmt::format("cdb {} ({} {} {} {} {} {} {}) hacd {}.{} meshoptimizer {} {}", kAlgorithm,
                     faces, concavity, compacity, least_pieces, vertices_per_hull, least_volume,
                     good_iou, HACD_VERSION_MAJOR, HACD_VERSION_MINOR, MESHOPTIMIZER_VERSION,
                     ConvexHullVersion());
}

}  // namespace cdb::meshes
