#include "library/meshes/decompose.h"

#include <fmt/format.h>
#include <hacdHACD.h>
#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "dsl/text/check.h"
#include "library/meshes/mass_properties.h"
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
          volume.IntersectionOverUnion(), SignedVolume(mesh) / volume.first - 1};
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

namespace {

using Eigen::Vector2d;

struct Crossing {
  std::uint32_t ray;
  std::uint8_t solid;  ///< 0 or 1
  std::int8_t turns;   ///< 1 into the surface, -1 out of it
  double at;           ///< along the ray
};

/// Rays along one axis, through the middles of the cells of a grid in the plane of the other two.
class Rays {
 public:
  explicit Rays(const Eigen::AlignedBox3d& box) {
    box.sizes().maxCoeff(&along_);
    low_ = Flat(box.min());
    step_ = (Flat(box.max()) - low_) / kRays;
  }

  double CellArea() const { return step_.prod(); }

  /// All crossings with the mesh, unordered.
  void Cast(const Mesh& mesh, std::uint8_t solid, std::vector<Crossing>& crossings) const {
    std::vector<int> balance(std::size_t{kRays} * kRays, 0);
    const std::size_t begin = crossings.size();
    for (const Triangle& triangle : mesh.triangles) {
      Eigen::AlignedBox2d box;
      for (const Vector3d& corner : CornersOf(mesh, triangle)) box.extend(Flat(corner));
      const int u_end = CellFrom(box.max().x(), 0, true), v_end = CellFrom(box.max().y(), 1, true);
      for (int u = CellFrom(box.min().x(), 0, false); u < u_end; ++u)
        for (int v = CellFrom(box.min().y(), 1, false); v < v_end; ++v) {
          const auto crossing = Cross(mesh, triangle, RayAt(u, v));
          if (!crossing) continue;
          const auto ray = static_cast<std::uint32_t>(u * kRays + v);
          crossings.push_back({ray, solid, crossing->turns, crossing->at});
          balance[ray] += crossing->turns;
        }
    }
    // A ray leaves as often as it enters, unless it hit an edge so closely that rounding decided;
    // such a ray is displaced slightly until it does.
    for (std::uint32_t ray = 0; ray < balance.size(); ++ray)
      if (balance[ray] != 0) CastAside(mesh, solid, ray, begin, crossings);
  }

 private:
  Vector2d Flat(const Vector3d& p) const { return {p[(along_ + 1) % 3], p[(along_ + 2) % 3]}; }

  Vector2d RayAt(int u, int v) const {
    return low_ + step_.cwiseProduct(Vector2d(u + 0.5, v + 0.5));
  }

  /// The first cell whose ray may be beyond `coordinate`; one too many is harmless.
  int CellFrom(double coordinate, int axis, bool is_end) const {
    const double cell = (coordinate - low_[axis]) / step_[axis] - 0.5;
    return static_cast<int>(
        std::clamp(is_end ? std::floor(cell) + 2 : std::floor(cell) - 1, 0.0, double{kRays}));
  }

  /// The side of the line through two vertices on which the ray is: exactly the negative value if
  /// the vertices are exchanged; never 0.
  double Side(const Mesh& mesh, std::uint32_t from, std::uint32_t to, const Vector2d& ray) const {
    const Vector2d low = Flat(mesh.vertices[std::min(from, to)]) - ray;
    const Vector2d high = Flat(mesh.vertices[std::max(from, to)]) - ray;
    double side = low.x() * high.y() - low.y() * high.x();
    if (side == 0) side = std::numeric_limits<double>::min();
    return from < to ? side : -side;
  }

  struct Hit {
    std::int8_t turns;
    double at;
  };
  std::optional<Hit> Cross(const Mesh& mesh, const Triangle& t, const Vector2d& ray) const {
    const double opposite[3] = {Side(mesh, t[1], t[2], ray), Side(mesh, t[2], t[0], ray),
                                Side(mesh, t[0], t[1], ray)};
    const bool is_left = opposite[0] > 0;
    if (is_left != (opposite[1] > 0) || is_left != (opposite[2] > 0)) return std::nullopt;
    double sum = 0, at = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      sum += opposite[i];
      at += opposite[i] * mesh.vertices[t[i]][along_];
    }
    // Counter-clockwise as seen from the far end of the ray, which is outside.
    return Hit{static_cast<std::int8_t>(is_left ? -1 : 1), at / sum};
  }

  void CastAside(const Mesh& mesh, std::uint8_t solid, std::uint32_t ray, std::size_t begin,
                 std::vector<Crossing>& crossings) const {
    const auto first = crossings.begin() + static_cast<std::ptrdiff_t>(begin);
    crossings.erase(
        std::remove_if(first, crossings.end(), [&](const Crossing& c) { return c.ray == ray; }),
        crossings.end());
    const Vector2d middle = RayAt(static_cast<int>(ray) / kRays, static_cast<int>(ray) % kRays);
    for (int tries = 1;; ++tries) {
      CDB_CHECK(tries < 100);  // the mesh is not closed
      const Vector2d aside =
          middle + step_.cwiseProduct(Vector2d(std::cos(tries), std::sin(tries))) / 64;
      std::vector<Crossing> found;
      int balance = 0;
      for (const Triangle& triangle : mesh.triangles)
        if (const auto hit = Cross(mesh, triangle, aside)) {
          found.push_back({ray, solid, hit->turns, hit->at});
          balance += hit->turns;
        }
      if (balance != 0) continue;
      crossings.insert(crossings.end(), found.begin(), found.end());
      return;
    }
  }

  int along_ = 0;
  Vector2d low_, step_;
};

}  // namespace

OverlapVolume OverlapVolumeOf(const Mesh& first, const Mesh& second) {
  Eigen::AlignedBox3d box;
  for (const Mesh* mesh : {&first, &second})
    for (const Vector3d& vertex : mesh->vertices) box.extend(vertex);
  const Rays rays(box);
  std::vector<Crossing> crossings;
  rays.Cast(first, 0, crossings);
  rays.Cast(second, 1, crossings);
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return a.ray != b.ray ? a.ray < b.ray : a.at < b.at;
  });
  OverlapVolume volume;
  int winding[2] = {0, 0};
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    if (i > 0 && crossings[i].ray == crossings[i - 1].ray) {
      const double length = crossings[i].at - crossings[i - 1].at;
      if (winding[0] > 0) volume.first += length;
      if (winding[1] > 0) volume.second += length;
      if (winding[0] > 0 && winding[1] > 0) volume.common += length;
    } else {
      winding[0] = winding[1] = 0;
    }
    winding[crossings[i].solid] += crossings[i].turns;
  }
  volume.first *= rays.CellArea();
  volume.second *= rays.CellArea();
  volume.common *= rays.CellArea();
  return volume;
}

}  // namespace cdb::meshes
